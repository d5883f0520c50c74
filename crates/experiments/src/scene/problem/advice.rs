//! Advice on how to solve the problems of a scene.

use super::SceneProblem;
use crate::claim::list;
use afterbay_core::InputError;
use afterbay_systems::CustomError;

/// The most tables that are named where a key is in the wrong one. A choice: more would be nearly
/// all.
const MOST_TABLES: usize = 3;

impl SceneProblem {
    /// Advice on how to solve the problem.
    pub fn help(&self) -> Option<String> {
        match self {
            Self::UnknownKey { key, known, .. } if is_count_of_branch(key, known) => Some(format!(
                "leave it out: a branch of limit cycles has the values that its continuation \
                 takes; {}",
                list_of("the keys are", known)
            )),
            Self::UnknownKey { key, known, tables } => Some(match tables.len() {
                1..=MOST_TABLES if nearest(key, known).is_none() => {
                    let all = suggestion(key, known, "the keys are");
                    format!("{all}; {key} is a key of {}", list(tables.iter().cloned()))
                }
                _ => suggestion(key, known, "the keys are"),
            }),
            // The nearest name of q7 is q1, which helps no one.
            Self::Unknown { what: "quantity", known, .. } => Some(list_of("there are", known)),
            Self::Unknown { what: "method", name, known } => Some(method(name, known)),
            Self::Unknown { name, known, .. } => Some(suggestion(name, known, "there are")),
            Self::UnknownMethods { names, known } => Some(suggestions(names, known)),
            Self::OffGrid { step, base } => {
                let multiple = (step / base).round().max(1.0) * base;
                let digits = format!("{multiple:.12e}").parse().unwrap_or(multiple);
                Some(format!("write {digits:?}, or a base_step that divides {step:?}"))
            }
            Self::Indivisible { end, h, nearest, .. } => Some(match short_steps(*end, *h) {
                [Some(below), Some(above)] => format!("{below} and {above} divide it"),
                [Some(step), None] | [None, Some(step)] => format!("{step} divides it"),
                [None, None] => format!("{nearest:?} divides it"),
            }),
            Self::Budget { change, .. } => Some((*change).into()),
            Self::Unsupported { others, .. } => Some(applying(others)),
            Self::Length { set_by, .. } => Some(set_by.clone()),
            Self::AtPoint { problem, .. } => problem.help(),
            Self::OffPeriod { period, .. } => {
                Some(format!("leave it out, or write a multiple of {period:?}"))
            }
            Self::Expression(problem) | Self::Custom(CustomError::Expression { problem, .. }) => {
                problem.advice()
            }
            Self::Missing { key } => example(key).map(Into::into),
            _ => self.remedy().map(Into::into),
        }
    }

    /// The advice that is the same for all problems of a kind.
    fn remedy(&self) -> Option<&'static str> {
        Some(match self {
            Self::Adaptive { .. } => {
                "give `tolerance` in [run], or `tolerances` in [study.work-precision]"
            }
            Self::ChoosesSteps { .. } => {
                "name others as `methods` of the study; [study.work-precision] with `tolerances` \
                 measures this one"
            }
            Self::ControlCharacter => "leave out escapes such as \\u0000, \\n and \\t",
            Self::FileName { .. } => "a name has letters, digits, `-` and `_`, at most 100 of them",
            Self::Quoted { .. } => "write the number without quotation marks",
            Self::LargeWhole { .. } => {
                "where any number may stand, write it as 1e20; a count is at most \
                 9223372036854775807"
            }
            Self::NoText => "save the file as UTF-8",
            Self::TooLarge { .. } => "is this the right file?",
            Self::Syntax(_) => "scenes are TOML files: see https://toml.io, and `afterbay schema`",
            Self::Nothing { .. } => "`afterbay schema` describes all tables a scene may have",
            Self::Input(InputError::Unsupported { .. }) => NEEDS,
            Self::NoMatrix => {
                "write friction = [[\"c\"]], a row for each degree of freedom, or \
                 dissipation = [\"c*v1\"], a force for each"
            }
            Self::OneStep => "write steps = [0.1, 0.05], or give one to [run]",
            Self::OneForm => {
                "write [0.1, 0.2], { from = 0, to = 1, count = 5 }, { uniform = [0, 1] } or \
                 { normal = [0, 1] }"
            }
            Self::NoCount => "write q = { count = 8, value = .. } in [initial], or a list",
            Self::NoPeriod => {
                "t shows a period where it occurs only in sines, cosines and remainders (`mod`) \
                 whose frequencies are multiples of one, the lowest at most 12 times it; that of \
                 forces may be given, as period = \"2*pi/omega\" in [drive]. A constant force f \
                 belongs in the potential, as -f*q1. [study.poincare] and [study.bifurcation] also \
                 take a section such as section = { of = \"q1\", direction = \"rising\" }"
            }
            Self::TwoAxes => {
                "write grid = { q1 = { from = -2, to = 2, count = 100 }, \
                 p1 = { from = -2, to = 2, count = 100 } }"
            }
            Self::Changes { .. } => {
                "leave the event out, to measure the motion without it; or use `afterbay run`, on \
                 a scene without [study.*]"
            }
            Self::NoMethods => "name `methods` here, or in [run] for all studies",
            Self::Custom(CustomError::NotFinite { value, .. }) if value.is_nan() => {
                "start where H and all forces are finite. Roots of negative numbers and \
                 logarithms of numbers up to 0 have no value. A power with a parameter in its \
                 exponent, such as q1^m, has one only for q1 > 0: write the exponent as a number, \
                 as in q1^4"
            }
            Self::Input(InputError::NotFinite { value, .. }) if value.is_nan() => {
                "start where H and all forces are finite. The derivative of a root, or of a power \
                 that is not whole, has no value where its base is 0; powers of max(x, 0) and \
                 abs(x) above 1 have one, with the exponent written as a number"
            }
            Self::Custom(CustomError::NotFinite { .. })
            | Self::Input(InputError::NotFinite { .. }) => {
                "start where H and all forces are finite"
            }
            _ => return None,
        })
    }
}

/// An example of a key or a table that is missing.
fn example(key: &str) -> Option<&'static str> {
    Some(match key {
        "initial" => "for example:  [initial]  q = [1.0]  p = [0.0]",
        "time" => "for example:  [time]  end = 10.0  step = 0.01",
        "system" => "for example:  [system]  name = \"duffing\"",
        "name" => {
            "name = \"custom\" for a V or H of your own; `afterbay list systems` shows the others"
        }
        "y" => "a quantity such as y = \"q1\", or a map such as map = \"q\"",
        "spread" => "how far the starts lie from the initial state: spread = 0.5",
        "step" => "the size of a step, such as step = 0.01",
        _ => return None,
    })
}

/// The nearest steps of at most two digits that divide the end, between h/2 and h and between h and
/// 2 h.
fn short_steps(end: f64, h: f64) -> [Option<String>; 2] {
    let exponent = h.log10().floor() - 1.0;
    let step = |digits: u32, shift: f64| format!("{digits}e{}", exponent + shift).parse::<f64>();
    let divides = |step: &f64| {
        let steps = end / step;
        steps >= 0.5 && (steps - steps.round()).abs() <= 1e-9 * steps
    };
    let all = || {
        let steps = (-1..2).flat_map(|shift| (10..100).map(move |digits| (digits, shift)));
        let steps = steps.filter_map(|(digits, shift)| step(digits, f64::from(shift)).ok());
        steps.filter(|step| (0.5 * h..=2.0 * h).contains(step)).filter(divides)
    };
    let below = all().filter(|step| *step < h).max_by(f64::total_cmp);
    let above = all().filter(|step| *step > h).min_by(f64::total_cmp);
    [below, above]
        .map(|step| step.map(|step| format!("{step:?}").trim_end_matches(".0").to_owned()))
}

/// Other names of methods.
const ALSO_CALLED: [(&str, &str); 8] = [
    ("verlet", "leapfrog"),
    ("velocity-verlet", "leapfrog"),
    ("stoermer-verlet", "leapfrog"),
    ("runge-kutta", "rk4"),
    ("dop853", "adaptive-dop853"),
    ("midpoint", "implicit-midpoint"),
    ("gauss", "collocation-4"),
    ("discrete-gradient", "increment-2"),
];

/// The advice for an unknown method: the method meant, or the nearest names.
fn method(name: &str, known: &[String]) -> String {
    let lower = name.to_lowercase();
    match ALSO_CALLED.iter().find(|(other, _)| *other == lower) {
        Some((_, meant)) => format!("did you mean {meant}?"),
        None => suggestion(&lower, known, "there are"),
    }
}

/// The nearest of the known names for each name that has a similar one, and all known names if one
/// has none.
fn suggestions(names: &[String], known: &[String]) -> String {
    let (mut said, mut all) = (Vec::new(), String::new());
    for name in names {
        let advice = method(name, known);
        match advice.strip_prefix("did you mean ") {
            Some(nearest) => said.push(format!("{name}: did you mean {nearest}")),
            None => all = advice,
        }
    }
    said.extend((!all.is_empty()).then_some(all));
    said.join(" ")
}

/// The command that lists the requirements of methods.
const NEEDS: &str = "`afterbay list methods` says what each method needs";
/// The most methods named as those that apply.
const MOST_APPLYING: usize = 8;

/// The methods that apply, in words.
fn applying(others: &[&str]) -> String {
    let named = others.get(..MOST_APPLYING).unwrap_or(others).join(", ");
    let more = if others.len() > MOST_APPLYING { ", .." } else { "" };
    if others.is_empty() { NEEDS.into() } else { format!("{named}{more} apply; {NEEDS}") }
}

/// The nearest name if one is similar, else all names.
pub(crate) fn suggestion(name: &str, known: &[String], before: &str) -> String {
    match nearest(name, known) {
        Some(nearest) => format!("did you mean {nearest}?"),
        None if known.is_empty() => "there are none".into(),
        None => list_of(before, known),
    }
}

/// All known names, behind these words, which are in the plural.
fn list_of(before: &str, known: &[String]) -> String {
    match known {
        [one] => format!("the only one is {one}"),
        _ => format!("{before} {}", known.join(", ")),
    }
}

/// Whether a key is that of a range, in a table of the parameter of a branch of limit cycles.
fn is_count_of_branch(key: &str, known: &[String]) -> bool {
    matches!(key, "count" | "scale") && known.iter().any(|name| name == "doublings")
}

/// The known name that a misspelt one may mean.
fn nearest<'k>(name: &str, known: &'k [String]) -> Option<&'k String> {
    let far = |other: &String| strsim::damerau_levenshtein(name, other);
    let nearest = known.iter().min_by_key(|other| far(other))?;
    let near = far(nearest) < name.len() && far(nearest) <= 1 + nearest.len().min(name.len()) / 3;
    near.then_some(nearest)
}
