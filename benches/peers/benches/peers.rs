//! Work-precision comparison with other libraries: prints a table of ratios, and writes every
//! figure to `out/peers`.
//!
//! ```text
//! cargo bench -p afterbay-peers [-- SCENE ...]
//! ```
//!
//! Boost.odeint takes part where a C++ compiler and its headers are (Debian: g++, libboost-dev),
//! heyoka and LSODA where `python3` can import heyoka, and numbalsoda with numba.
//!
//! Run it on an idle machine. All runs of a scene are timed in turns and the minimum of their times
//! counts, but continuous load slows some loops more than others. A run that takes longer than 0.3
//! s is the last of its line; on C2 this leaves little more than one tolerance for explicit
//! methods.

use afterbay_peers::measure::{self, Patience};
use afterbay_peers::{external, lines, ours, ratios, report, scenes};
use std::path::Path;
use std::time::{Duration, Instant};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // `cargo test` also runs benches, without this argument; a short run then checks that they
    // work.
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let full = arguments.iter().any(|argument| argument == "--bench");
    let patience = if full {
        Patience {
            settings: usize::MAX,
            turns: 3,
            least: Duration::from_millis(20),
            most: Duration::from_millis(300),
        }
    } else {
        Patience { settings: 2, turns: 1, least: Duration::ZERO, most: Duration::from_millis(20) }
    };
    let named = |name: &str| arguments.iter().any(|argument| argument == name);
    let mut scenes = scenes::all().to_vec();
    if scenes.iter().any(|scene| named(scene.name)) {
        scenes.retain(|scene| named(scene.name));
    } else if !full {
        scenes.retain(|scene| ["A", "D64", "E"].contains(&scene.name));
    }
    let temporary = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let libraries = external::found(temporary, |why| eprintln!("{why}"));
    let mut all = Vec::new();
    for scene in &scenes {
        let clock = Instant::now();
        let mut here = ours::lines(scene);
        here.extend(lines(scene));
        here.extend(libraries.iter().flat_map(|library| library.lines(scene)));
        let rows = measure::all(scene, &here, patience)?;
        eprintln!("{}: {} runs in {:.1} s", scene.name, rows.len(), clock.elapsed().as_secs_f64());
        all.push((scene.clone(), rows));
    }
    println!("time to an error at the end");
    print(&ratios::HEADER.map(String::from));
    all.iter().flat_map(|(_, rows)| ratios::table(rows)).for_each(|entry| print(&entry));
    println!("\nfaster elsewhere:");
    all.iter().flat_map(|(_, rows)| ratios::slower(rows)).for_each(|case| println!("{case}"));
    if full {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../out/peers");
        report::write(&all, &folder)?;
        println!("out/peers/report.html, out/peers/data/work_precision.csv");
    }
    Ok(())
}

fn print([scene, part, who, a, b, c]: &ratios::Entry) {
    println!("{scene:6} {part:8} {who:30} {a:>34} {b:>34} {c:>34}");
}
