//! The exact flow of linear systems under forces that are sums of sines and cosines of the time.

use afterbay_core::taylor::trajectory;
use afterbay_core::{
    Abilities, Clocked, Drive, Driven, Grid, InputError, Quad, Scalar, Series, State, StateRef,
    System, with_motors,
};
use afterbay_methods::registry::{Number, Run, bind, find};
use afterbay_systems::{Custom, CustomDrive, Description, DissipationText, DriveDescription};
use allocation_counter::measure;
use std::ops::ControlFlow;
use std::sync::Arc;

mod closed_forms;
mod random;

/// A linear system and the forces on it.
#[derive(Clone)]
struct Case {
    custom: Custom<f64>,
    drive: CustomDrive<f64>,
}

fn texts(texts: &[&str]) -> Vec<String> {
    texts.iter().map(ToString::to_string).collect()
}

impl Case {
    fn new(
        potential: &str,
        dissipation: DissipationText,
        masses: &[&str],
        forces: &[&str],
    ) -> Self {
        let (potential, masses) = (potential.to_owned(), texts(masses));
        let description = Description { potential, dissipation, masses, ..Default::default() };
        let custom = Custom::new(&description).unwrap();
        let forces = DriveDescription { forces: texts(forces), ..Default::default() };
        let (drive, _) = CustomDrive::new(&forces, custom.dof()).unwrap();
        Self { custom, drive }
    }

    /// x'' + b x' + k x = F
    fn oscillator(k: f64, b: f64, force: &str) -> Self {
        let drag = DissipationText::Forces(vec![format!("{b:?}*v1")]);
        Self::new(&format!("{k:?}*q1^2/2"), drag, &[], &[force])
    }

    fn motors(&self) -> &[usize] {
        Drive::<f64>::driven(&self.drive)
    }

    fn driven<T: Scalar>(
        &self,
        lift: impl Fn(f64) -> T,
    ) -> Arc<Driven<dyn Abilities<T>, dyn Drive<T>>> {
        let system: Arc<dyn Abilities<T>> = Arc::new(self.custom.map(&lift));
        let drive: Arc<dyn Drive<T>> = Arc::new(self.drive.lift(|_, x| lift(x)));
        Arc::new(Driven::new(system, drive).unwrap())
    }

    fn bound<T: Number>(&self) -> Result<Run<T>, InputError> {
        bind(find("linear-exact").unwrap(), self.driven(T::from_f64))
    }

    /// The state at t with the motors, in any scalar.
    fn start<T: Scalar>(&self, [q, p]: [&[f64]; 2], t: f64) -> State<Vec<T>> {
        let lift = |x: &[f64]| x.iter().map(|&x| T::from_f64(x)).collect();
        let state = State { t: T::from_f64(t), ..State::new(lift(q), lift(p)).unwrap() };
        with_motors(&state, self.motors().len())
    }

    /// [q, p, w, s] of the degrees of freedom, in 31 digits.
    fn parts<T: Scalar>(&self, state: &State<Vec<T>>) -> [Vec<Quad>; 4] {
        let wide = |x: &[T]| x.iter().map(|&x| widen(x)).collect::<Vec<_>>();
        let n = self.custom.dof();
        let mut w = wide(&state.w[..n]);
        for (&j, &s) in self.motors().iter().zip(&state.p[n..]) {
            w[j] += widen(s);
        }
        let s = state.w[n..].iter().map(|&w| -widen(w)).collect();
        [wide(&state.q[..n]), wide(&state.p[..n]), w, s]
    }
}

fn widen<T: Scalar>(x: T) -> Quad {
    let high = x.to_f64();
    Quad::from_f64(high) + Quad::from_f64((x - T::from_f64(high)).to_f64())
}

fn narrow<T: Scalar>(x: Quad) -> T {
    T::from_f64(x.0) + T::from_f64(x.1)
}

/// The largest difference of these parts.
fn distance(a: &[Vec<Quad>; 4], b: &[Vec<Quad>; 4]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.fold(0.0, |most, (&a, &b)| most.max((a - b).to_f64().abs()))
}

/// Three coupled degrees of freedom: one overdamped, one without friction, a constant force, two
/// frequencies, one of which belongs to two forces.
fn web(third: &str) -> Case {
    let potential = "q1^2/2 + 2*(q2 - q1)^2 + (q3 - q2)^2/2 + q3^2/4 + 0.3*q2";
    let rows = [["0.5", "0.25", "0"], ["0.25", "7", "0"], ["0", "0", "0"]];
    let drag = DissipationText::Matrix(rows.map(|row| texts(&row)).to_vec());
    let forces = ["0.7*cos(1.3*t + 0.4)", "0.2 - sin(2.9*t)/2", third];
    Case::new(potential, drag, &["1", "2", "0.5"], &forces)
}

fn coupled_to<T: Number>(allowed: f64) {
    let (q, p) = ([0.5, -0.25, 1.0], [0.125, 0.75, -0.5]);
    let product = "0.3*sin(1.3*t)*cos(1.3*t)^2";
    for (h, t0, third) in
        [(0.0009765625, 0.0, product), (0.375, 4096.5, "sin(1.3*t)"), (20.0, -7.0, product)]
    {
        let case = web(third);
        let series = case.driven(|x| Series::<Quad, 24>::constant(Quad::from_f64(x)));
        let start = case.start::<Quad>([&q, &p], t0);
        let exact = trajectory::<_, _, 24>(&*series, &start, Quad::from_f64(h), 2).unwrap();
        let run = case.bound::<T>().unwrap();
        let mut state = case.start::<T>([&q, &p], t0);
        for exact in &exact[1..] {
            run.step(T::from_f64(h), &mut state).unwrap();
            let exact = case.parts(exact);
            let far = distance(&case.parts(&state), &exact);
            let size = exact[3].iter().fold(1.0, |most: f64, s| most.max(s.to_f64().abs()));
            assert!(far < allowed * size, "h = {h}: off by {far:e} of {size:e}");
        }
    }
}

/// Friction that is small beside the force is known to the rounding of their sum.
#[test]
fn locally_exact_steps_take_friction_that_couples_driven_momenta() {
    let rows = [["0.3", "-0.1"], ["-0.1", "0.2"]];
    let drag = DissipationText::Matrix(rows.map(|row| texts(&row)).to_vec());
    let case = Case::new("q1^2/2 + q2^2", drag, &[], &["cos(t)", "0"]);
    let end = |name: &str| {
        let run = bind::<f64>(find(name).unwrap(), case.driven(|x| x)).unwrap();
        let mut state = case.start::<f64>([&[1.0, 0.0], &[0.0, 0.0]], 0.0);
        let go_on = &mut |_, _: StateRef<'_, f64>| ControlFlow::Continue(());
        let done = run.run(Grid::of(0.1, 100).unwrap(), &mut state, 100, go_on);
        done.unwrap_or_else(|error| panic!("{name}: {error}"));
        case.parts(&state)
    };
    let off = distance(&end("locally-exact"), &end("linear-exact"));
    assert!(off < 0.01, "{off:e}");
}

#[test]
fn coupled_motion_agrees_with_the_taylor_series() {
    coupled_to::<f64>(4e-15);
    coupled_to::<Quad>(1e-29);
}

/// A constant force f does the work f Δq, as the potential -f q does.
#[test]
fn a_constant_force_is_a_slope_of_v() {
    let (driven, tilted) = (
        Case::oscillator(1.0, 0.25, "0.625 + cos(t)/2"),
        Case::new(
            "q1^2/2 - 0.625*q1",
            DissipationText::Forces(vec!["0.25*v1".into()]),
            &[],
            &["cos(t)/2"],
        ),
    );
    for h in [0.125, 3.0] {
        let [a, b] = [driven.clone(), tilted.clone()].map(|case| {
            let mut state = case.start::<f64>([&[0.5], &[0.25]], 1.0);
            case.bound::<f64>().unwrap().step(h, &mut state).unwrap();
            case.parts(&state)
        });
        let work = Quad::from_f64(0.625) * (b[0][0] - Quad::from_f64(0.5));
        let exact = [b[0].clone(), b[1].clone(), b[2].clone(), vec![b[3][0] + work]];
        assert!(distance(&a, &exact) < 1e-15, "{a:?}, not {exact:?}");
    }
}

#[test]
fn steps_allocate_nothing() {
    let case = web("sin(1.3*t)");
    let run = case.bound::<f64>().unwrap();
    let mut state = case.start::<f64>([&[0.5; 3], &[0.25; 3]], 0.0);
    let mut allocations = |steps: u64| {
        let grid = Grid::of(0.125, steps).unwrap();
        let look = &mut |_: u64, _: StateRef<'_, f64>| ControlFlow::Continue(());
        let counts = measure(|| {
            run.run(grid, &mut state, u64::MAX, look).unwrap();
        });
        counts.count_total
    };
    allocations(1);
    assert_eq!(allocations(1000), allocations(1));
}

fn refusal(case: &Case) -> String {
    case.bound::<f64>().expect_err("a refusal").to_string()
}

#[test]
fn refusals_say_why() {
    for (potential, force, why) in [
        ("q1^4", "cos(t)", "the system is not linear"),
        ("q1^2", "q1*cos(t)", "a force of the drive depends on a coordinate"),
        ("q1^2", "exp(-t)", "a force of the drive is not a sum of sines and cosines of t"),
        ("q1^2", "(1 + cos(t))^13", "the drive has more than 12 frequencies"),
    ] {
        let case = Case::new(potential, DissipationText::None, &["1"], &[force]);
        let found = refusal(&case);
        assert_eq!(found, format!("linear-exact does not apply: {why}"));
    }
    let wide = |n: usize| {
        let potential = (1..=n).map(|j| format!("q{j}^2")).collect::<Vec<_>>().join(" + ");
        let forces: Vec<_> = std::iter::once("cos(t)").chain(vec!["0"; n - 1]).collect();
        Case::new(&potential, DissipationText::None, &vec!["1"; n], &forces)
    };
    assert!(wide(12).bound::<f64>().is_ok());
    assert!(refusal(&wide(13)).contains("up to 12 degrees of freedom"));
}

#[test]
fn a_clock_is_refused() {
    // q2 is the time.
    let case = Case::new("q1^2*cos(q2)", DissipationText::None, &["1", "1"], &["cos(t)", "0"]);
    let inner: Arc<dyn Abilities<f64>> = Arc::new(case.custom.map(|x| x));
    let clocked: Arc<dyn Abilities<f64>> = Arc::new(Clocked::new(inner).unwrap());
    let drive: Arc<dyn Drive<f64>> = Arc::new(case.drive.clone());
    let driven: Arc<dyn Abilities<f64>> = Arc::new(Driven::new(clocked.clone(), drive).unwrap());
    for system in [clocked, driven] {
        let refused = bind::<f64>(find("linear-exact").unwrap(), system).err().unwrap().to_string();
        assert_eq!(refused, "linear-exact does not apply: V or D depends on the time");
    }
}
