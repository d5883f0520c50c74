//! Built-in systems, states, times, methods and studies that are not valid.

use super::Change;

pub(super) const GOOD: &str = r#"[system]
name = "damped-oscillator"
parameters = { k = 1.0, b = 0.1 }
[initial]
q = [2.3]
p = [-3.1]
[time]
end = 20.0
step = 0.01
[run]
methods = ["moddg", "rk4"]
every = 10
[study.local-order]
base_step = 0.001
steps = [0.02, 0.01]
[study.global-order]
steps = [0.1, 0.05]
[study.energy]
step = 0.01
every = 100
[study.work-precision]
methods = ["leapfrog"]
steps = { from = 0.1, to = 0.2, count = 2 }
[study.stability]
steps = { from = 0.01, to = 10.0, count = 6, scale = "log" }
parameter = { name = "b", from = 0.0, to = 9.0, count = 3 }
[study.long-run]
count = 1000
"#;

/// The oscillator with its initial state, and other systems to replace it.
const STATE: &str = "name = \"damped-oscillator\"\nparameters = { k = 1.0, b = 0.1 }\n[initial]\n\
                     q = [2.3]\np = [-3.1]";
const CHAIN: &str = "name = \"fput-chain\"\nparameters = { n = 2, beta = 1, c = 0.1 }\n[initial]\n\
                     q = [1, 2]\np = [0, 0]";
const DUFFING: &str = r#"[system]
name = "duffing"
parameters = { alpha = 1, beta = 1, c = 0.1 }
[initial]
q = [1]
p = [0]
[time]
end = 1
step = 0.1
[run]
methods = ["linear-exact"]
"#;
const VARIED_CHAIN: &str = r#"[system]
name = "fput-chain"
parameters = { n = 1, beta = 1, c = 0.1 }
[initial]
q = [1]
p = [0]
[time]
end = 1
step = 0.1
[study.stability]
methods = ["rk4"]
steps = [0.1]
parameter = { name = "n", from = 1, to = 3, count = 3 }
"#;
const DOUBLE_PENDULUM: &str = r#"name = "damped-double-pendulum"
parameters = { m1 = 1, m2 = 1, l1 = 1, l2 = 1, g = 9.81, c1 = 0, c2 = 0 }
[initial]
q = [1, 2]
p = [0, 0]"#;

/// Changes of [`GOOD`].
pub(super) const CHANGES: &[Change] = &[
    // Events that studies do not follow.
    (
        "[study.local-order]",
        "[run.events.wall]\nof = \"q1\"\naction = \"bounce\"\n[study.local-order]",
        "action = \"bounce\"",
        "the event wall changes the state: neither a study nor `pick` follows it",
        "leave the event out",
    ),
    (
        "steps = [0.02, 0.01]",
        "steps = [0.02]",
        "steps = [0.02]",
        "an order needs two steps at least",
        "steps = [0.1, 0.05]",
    ),
    (
        "[study.local-order]",
        "[sweep]\nvary.b = { normal = [0.1] }\n[study.local-order]",
        "{ normal = [0.1] }",
        "{ normal = [mean, deviation] }",
        "",
    ),
    // Systems and their parameters.
    (
        "\"damped-oscillator\"",
        "\"damped-oscilator\"",
        "name = \"damped-oscilator\"",
        "no system damped-oscilator",
        "mean damped-oscillator",
    ),
    (
        "\"damped-oscillator\"",
        "\"nothing\"",
        "name = \"nothing\"",
        "no system nothing",
        "van-der-pol-ring, damped-double-pendulum, custom",
    ),
    ("b = 0.1 }", "bb = 0.1 }", "bb = 0.1", "no parameter bb", "mean b"),
    ("{ k = 1.0, b = 0.1 }", "{ k = 1.0 }", "parameters", "the key parameters.b is missing", ""),
    ("parameters = { k = 1.0, b = 0.1 }\n", "", "system", "the key parameters.k is missing", ""),
    (
        "{ k = 1.0, b = 0.1 }",
        "{ k = 1.0, b = 0.1, c = 2 }",
        "c = 2",
        "no parameter c",
        "there are k, b",
    ),
    ("k = 1.0", "k = 0", "k = 0", "parameter k = 0.0 must be", ""),
    ("k = 1.0", "k = \"2*b\"", "name = \"b\"", "b cannot be varied: k is computed from it", ""),
    ("k = 1.0", "k = \"2*q1\"", "q1", "q1 has no place here: this is made of numbers", ""),
    (
        STATE,
        "name = \"fput-chain\"\nparameters = { n = 0, beta = 1, c = 0 }\n[initial]\nq = []\np = []",
        "n = 0",
        "parameter n",
        "",
    ),
    (
        STATE,
        "name = \"fput-chain\"\nparameters = { n = 1.5, beta = 1, c = 0 }\n[initial]\nq = [1]\n\
         p = [1]",
        "n = 1.5",
        "parameter n = 1.5 must be a whole number",
        "",
    ),
    (
        STATE,
        "name = \"fput-chain\"\nparameters = { n = 1e9, beta = 1, c = 0 }\n[initial]\n\
         q = \"0.1*i\"\np = \"0\"",
        "n = 1e9",
        "must be a whole number from 1 to 1e6",
        "",
    ),
    (
        STATE,
        "name = \"fput-chain\"\nparameters = { n = 1e6, beta = 1, c = 0 }\n[initial]\nq = [1]\n\
         p = [1]",
        "q = [1]",
        "q has 1 entry",
        "",
    ),
    (
        "[initial]",
        "potential = \"q1^2\"\n[initial]",
        "potential = \"q1^2\"",
        "potential does not belong here",
        "",
    ),
    ("[initial]", "mass = [1]\n[initial]", "mass = [1]", "only a system called \"custom\"", ""),
    (
        "[initial]",
        "friction = [[1]]\n[initial]",
        "friction = [[1]]",
        "friction does not belong here",
        "",
    ),
    // States.
    ("q = [2.3]", "q = []", "q = []", "0 entries and the number of degrees of freedom is 1", ""),
    (
        "p = [-3.1]",
        "p = [-3.1, 0.0]",
        "p = [-3.1, 0.0]",
        "2 entries and the number of degrees of freedom is 1",
        "",
    ),
    ("q = [2.3]", "q = [1e300]", "initial", "H = inf is not finite", "start where"),
    // Times.
    (
        "end = 20.0\nstep = 0.01",
        "end = 20.0\nstep = 0.03",
        "step = 0.03",
        "20.0 is no multiple of the step h = 0.03",
        "divide it",
    ),
    ("end = 20.0\nstep = 0.01", "end = 20.0\nstep = 0", "step = 0", "h = 0.0 must be positive", ""),
    ("end = 20.0\nstep = 0.01", "end = 20.0\nstep = -0.01", "step = -0.01", "must be positive", ""),
    (
        "end = 20.0\nstep = 0.01",
        "end = 20.0\nstep = 40",
        "step = 40",
        "20.0 is no multiple",
        "20 divides it",
    ),
    ("end = 20.0", "end = 0", "end = 0", "the end of time 0.0 must be positive", ""),
    ("end = 20.0", "end = -20", "end = -20", "must be positive", ""),
    ("end = 20.0\nstep = 0.01", "end = 1e300\nstep = 1e-300", "step = 1e-300", "time stalls", ""),
    (
        "end = 20.0\nstep = 0.01",
        "end = 1e12\nstep = 1",
        "step = 1",
        "the number of steps would be 2.000e12",
        "larger steps",
    ),
    (
        "end = 20.0\nstep = 0.01\n[run]\nmethods = [\"moddg\", \"rk4\"]\nevery = 10",
        "end = 1e10\nstep = 1\n[run]\nmethods = [\"moddg\"]\nevery = 1",
        "every = 1",
        "the output in bytes would be",
        "`every`",
    ),
    ("every = 10\n", "every = 0\n", "every = 0", "every = 0 must be a whole number from 1", ""),
    ("every = 10\n", "tolerance = 0\n", "tolerance = 0", "must be finite and at least", ""),
    ("every = 10\n", "tolerance = -1e-6\n", "tolerance = -1e-6", "must be finite and at least", ""),
    ("every = 10\n", "tolerance = 1.5\n", "tolerance = 1.5", "must be less than 1", ""),
    (
        "every = 10\n",
        "sample = 1e-12\n",
        "sample = 1e-12",
        "the output in bytes",
        "a larger `sample`",
    ),
    ("[\"leapfrog\"]", "[\"leapfrog\"]\ntolerances = []", "tolerances = []", "one tolerance", ""),
    ("[\"leapfrog\"]", "[\"leapfrog\"]\ntolerances = [1e-6, 1]", "1", "must be less than 1", ""),
    ("every = 10\n", "tolerance = 1e-30\n", "tolerance = 1e-30", "must be finite and at least", ""),
    (
        "every = 10\n",
        "tolerances = [1e-6]\n",
        "tolerances",
        "there is no key tolerances",
        "mean tolerance",
    ),
    (
        "[\"leapfrog\"]",
        "[\"leapfrog\"]\ntolerances = [1e-6, 0]",
        "0",
        "must be finite and at least",
        "",
    ),
    (
        "[\"leapfrog\"]",
        "[\"leapfrog\"]\ntolerances = [1e-6, 1e-6]",
        "1e-6",
        "is in the list already",
        "",
    ),
    // Methods.
    ("\"rk4\"", "\"rk5\"", "\"rk5\"", "there is no method rk5", "mean rk4"),
    ("\"rk4\"", "\"adaptive-dop853\"", "\"adaptive-dop853\"", "takes a tolerance", "`tolerances`"),
    ("\"rk4\"", "\"\"", "\"\"", "there is no method", "leapfrog"),
    ("\"rk4\"", "\"moddg\"", "\"moddg\"", "moddg is in the list already", ""),
    (
        "methods = [\"moddg\", \"rk4\"]",
        "methods = [\"RK4\", \"rk4\", \"verlet\"]",
        "\"RK4\"",
        "there are no methods RK4, verlet",
        "RK4: did you mean rk4? verlet: did you mean leapfrog?",
    ),
    (
        "methods = [\"moddg\", \"rk4\"]",
        "methods = []",
        "methods = []",
        "give one method at least",
        "",
    ),
    (STATE, CHAIN, "\"moddg\"", "moddg does not apply", "list methods"),
    (
        "[\"leapfrog\"]",
        "[\"leapfrg\"]",
        "\"leapfrg\"",
        "there is no method leapfrg",
        "mean leapfrog",
    ),
    // Studies.
    ("[0.1, 0.05]", "[0.1, 0.03]", "0.03", "20.0 is no multiple of the step h = 0.03", "divide it"),
    ("[0.1, 0.05]", "[0.1, 0.1]", "0.1", "0.1 is in the list already", ""),
    ("[0.1, 0.05]", "[]", "steps = []", "give one step at least", ""),
    ("[0.1, 0.05]", "[-0.1]", "-0.1", "h = -0.1 must be positive", ""),
    (
        "[0.02, 0.01]",
        "[0.0205]",
        "0.0205",
        "the step 0.0205 is no multiple of base_step = 0.001",
        "write 0.021, or a base_step that divides 0.0205",
    ),
    (
        "base_step = 0.001",
        "base_step = 0.003",
        "base_step = 0.003",
        "20.0 is no multiple",
        "divide it",
    ),
    (
        "step = 0.01\nevery = 100",
        "step = 0.03\nevery = 100",
        "step = 0.03",
        "20.0 is no multiple",
        "divide it",
    ),
    ("every = 100", "every = 0", "every = 0", "a whole number from 1", ""),
    (
        "to = 0.2, count = 2",
        "to = 0.2, count = 0",
        "count = 0",
        "count = 0 must be from 1 to 100000",
        "",
    ),
    ("to = 0.2, count = 2", "to = 0.1, count = 2", "to = 0.1", "another value than `from`", ""),
    ("to = 0.2, count = 2", "to = 0.2, count = 3", "steps", "h = 0.15000000000000002", "divide it"),
    (
        "from = 0.01, to = 10.0",
        "from = 0, to = 10.0",
        "from = 0",
        "positive where the scale is \"log\"",
        "",
    ),
    ("from = 0.1, to = 0.2", "from = 0, to = 0.2", "from = 0", "from = 0 must be positive", ""),
    ("name = \"b\"", "name = \"bb\"", "name = \"bb\"", "there is no parameter bb", "mean b"),
    ("name = \"b\"", "name = \"n\"", "name = \"n\"", "there is no parameter n", "there are k, b"),
    (
        "parameter = { name = \"b\", from = 0.0, to = 9.0, count = 3 }",
        "parameter = { name = \"n\", from = 1, to = 3, count = 3 }",
        "name = \"n\"",
        "there is no parameter n",
        "there are k, b",
    ),
    (STATE, DOUBLE_PENDULUM, "\"moddg\"", "moddg does not apply", "list methods"),
    (GOOD, VARIED_CHAIN, "name = \"n\"", "changes the number of degrees of freedom", ""),
    (GOOD, DUFFING, "\"linear-exact\"", "linear-exact does not apply", "list methods"),
    ("name = \"b\"", "name = \"k\"", "parameter", "parameter k = 0.0 must be", ""),
    (
        "to = 9.0, count = 3",
        "to = 9.0, count = 100000",
        "stability",
        "the number of cells would be 1.200e6",
        "fewer steps or values",
    ),
    ("parameter = {", "end = -1\nparameter = {", "end = -1", "the end of time -1.0", ""),
    ("count = 1000", "count = 0", "count = 0", "count = 0 must be at least 1", ""),
    ("count = 1000", "count = 1000\nstep = -1", "step = -1", "h = -1.0 must be positive", ""),
    (
        "[run]\nmethods = [\"moddg\", \"rk4\"]\nevery = 10\n",
        "",
        "local-order",
        "no methods are named",
        "in [run]",
    ),
    (
        "[\"leapfrog\"]",
        "[\"moddg-p4-single\", \"linear-exact\", \"gonzalez-2\"]",
        "\"gonzalez-2\"",
        "no method gonzalez-2",
        "mean gonzalez",
    ),
];
