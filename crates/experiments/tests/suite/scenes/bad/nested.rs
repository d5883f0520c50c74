//! Endless brackets and dots, and other texts that are not scenes.

use super::{Bad, named};

pub(super) fn texts() -> impl Iterator<Item = Bad> {
    let (deep, dotted) = ("nested more than", |n: usize| "a.".repeat(n) + "a");
    let too_deep = [
        ("[".repeat(100_000), "["),
        (format!("[{}]\n", dotted(500_000)), "."),
        (format!("{} = 1\n", dotted(500_000)), "."),
        (format!("x = {{ {} = 1 }}\n", dotted(500_000)), "."),
        (format!("x = {{ y = 1,\n {} = 1 }}\n", dotted(500_000)), "."),
        (format!("x = {}", "{ x = ".repeat(100_000)), "{"),
        (format!("x = {}", "[{ x = ".repeat(100_000)), "["),
        (format!("x = {}{}", "[".repeat(100_000), "]".repeat(100_000)), "["),
        (format!("x = {}", format!("{{ {} = ", dotted(40)).repeat(1000)), "."),
        (format!("{}\"x\"{} = 1", "\"a\".".repeat(100_000), ".'b'".repeat(10)), "."),
    ];
    let nested = too_deep.map(|(text, at)| Bad { text, at: at.into(), says: deep, help: "" });
    let parentheses = |text: &str| {
        named::GOOD.replace(
            "name = \"damped-oscillator\"\nparameters = { k = 1.0, b = 0.1 }",
            &format!("name = \"custom\"\npotential = \"{text}\""),
        )
    };
    let (open, signs, long) = ("(".repeat(60_000), "-".repeat(60_000), "q1 + ".repeat(20_000));
    let others = [
        (String::new(), "", "is missing", ""),
        ("# nothing\n".to_owned(), "", "is missing", ""),
        ("hello".to_owned(), "", "", "toml.io"),
        (parentheses(&open), "", "nested deeper than 256", "leave out"),
        (parentheses(&signs), "", "nested deeper than 256", "leave out"),
        (parentheses(&long), long.as_str(), "bytes, and 65536 is the most", "sum("),
        (format!("x = \"{}", "a".repeat(100_000)), "", "", "toml.io"),
        (format!("x = [{}", "1,".repeat(100_000)), "", "", "toml.io"),
    ];
    let others: Vec<_> = others
        .into_iter()
        .map(|(text, at, says, help)| Bad { text, at: at.into(), says, help })
        .collect();
    nested.into_iter().chain(others)
}
