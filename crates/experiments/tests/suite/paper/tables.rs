//! The contract of the tables: their columns.

use super::PAPER;
use afterbay_experiments::data::Files;

#[test]
fn tables_follow_their_contract() {
    let output = &PAPER.0;
    for (name, columns) in [
        ("data/local_orders.csv", "method,variable,statistic,order,ci_low,ci_high,points,printed"),
        ("data/global_orders.csv", "method,variable,h,error,order,doubt"),
        ("data/energy.csv", "method,h,t,H,K_minus_K0,R,d_R,w_error,doubt_w,doubt_d_R,w1\n"),
        (
            "data/fput-chain/energy.csv",
            "method,h,t,H,K_minus_K0,R,d_R,w_error,doubt_w,doubt_d_R,w1,w2,w3\n",
        ),
        ("data/trajectory.csv", "method,step,t,q1,p1,w1,H,K\n"),
        ("data/damped-double-pendulum/trajectory.csv", "method,step,t,q1,q2,p1,p2,w1,w2,H,K\n"),
        (
            "data/work_precision.csv",
            "method,h,outcome,error_qp,error_w,k_drift,passivity_violations,seconds,steps,\
             evaluations,iterations",
        ),
        ("data/fput-chain/long_run.csv", "method,h,compensated,steps,t,rms,mean\n"),
        ("data/stability.csv", "method,h,parameter,value,verdict,spectral_radius,steps_done"),
    ] {
        let table = output.artifacts.iter().find(|artifact| artifact.name == name).expect(name);
        assert!(
            table.text.starts_with(columns),
            "{name}: {}",
            table.text.lines().next().unwrap_or("")
        );
        assert!(
            !table.text.contains("NaN") && !table.text.contains("inf"),
            "{name} has a number that is none"
        );
    }
    let html = output.report.html(Files::default());
    assert!(
        !html.replace("http://www.w3.org/2000/svg", "").contains("http"),
        "the report fetches something"
    );
    for figure in output.artifacts.iter().filter(|artifact| artifact.name.ends_with(".svg")) {
        assert!(html.contains(&figure.name), "{} is not in the report", figure.name);
        assert!(figure.text.len() < 300_000, "{} is {} bytes long", figure.name, figure.text.len());
    }
}
