//! model.toml: what is read, what is refused and where, and that writing loses nothing.

use stickslip_analysis::model::candidate;
use stickslip_analysis::model::expression::parse;
use stickslip_analysis::model::file::{EffectEntry, ModelFile};
use stickslip_shared::effects::formula::{Fault, Program, Variable};
use stickslip_shared::effects::{Effect, MAX_PARAMETERS, REGISTRY};
use stickslip_shared::model::Formulation;

const GOOD: &str = r#"format = "stickslip-model/1"
base = "hard"
[friction]
finger = 0.4
pusher = 0.25
support = 0.3
[[effects]]
id = "static_friction"
excess = 0.2
stribeck_speed_m_s = 0.002
elsewhere = 0.0
intervals = { excess = [0.15, 0.25] }
[[effects]]
id = "formula"
name = "my_hump"
target = "friction"
bodies = ["finger1", "finger2"]
expression = "1 + a*exp(-slip_speed_m_s/b)"
parameters = { a = {value = 0.1, low = 0, high = 1, unit = "1"}, b = {value = 0.002, low = 1e-4, high = 0.1, unit = "m/s"} }
"#;

fn evaluate(text: &str, names: &[&str], values: [f64; 6], variables: [f64; 10]) -> Result<f64, Fault> {
    let names: Vec<String> = names.iter().map(|n| n.to_string()).collect();
    let ops = parse(text, &names).unwrap();
    let mut all = [0.0; Variable::NAMES.len()];
    all[..10].copy_from_slice(&variables);
    let mut parameters = [0.0; MAX_PARAMETERS];
    parameters[..6].copy_from_slice(&values);
    Program::new(&ops).unwrap().evaluate(&parameters, &all)
}

#[test]
fn what_is_read_is_written_and_read_again_unchanged() {
    let file = ModelFile::parse(GOOD, "model.toml").unwrap();
    assert_eq!(ModelFile::parse(&file.write(), "again").unwrap(), file, "{}", file.write());
    let model = file.to_model();
    assert_eq!(model.effects.len(), 2);
    assert_eq!(model.formulas[0].bodies, 0b11);
    assert_eq!(model.effects[1].parameters[..2], [0.1, 0.002]);
    assert_eq!(model.cast::<f32>().cast::<f64>().friction.finger, f64::from(0.4_f32));
}

#[test]
fn the_formulation_is_the_cone_unless_the_file_says_otherwise() {
    assert_eq!(ModelFile::parse(GOOD, "m").unwrap().to_model().formulation, Formulation::Cone);
    for (base, soft) in
        [("hard", ""), ("soft", "[soft]\nnormal_n_m = 2e5\ntangential_n_m = 1e5\ndamping_s = 0.0\n")]
    {
        let text = format!(
            "format = 'stickslip-model/1'\nbase = '{base}'\nformulation = 'lcp'\n{soft}[friction]\nfinger = 0.4\npusher = 0.2\nsupport = 0.3\n"
        );
        let file = ModelFile::parse(&text, "m").unwrap();
        assert_eq!(file.to_model().formulation, Formulation::Lcp);
        assert_eq!(ModelFile::parse(&file.write(), "again").unwrap(), file, "{}", file.write());
        assert_eq!(ModelFile::of_model(&file.to_model(), &[]), file);
        let error = ModelFile::parse(&text.replacen("lcp", "pyramid", 1), "m").unwrap_err().to_string();
        assert!(error.starts_with("m:3:15:") && error.contains("\"cone\" or \"lcp\""), "{error}");
    }
}

#[test]
fn every_built_in_effect_survives_a_round_trip_of_its_typical_values() {
    for info in REGISTRY {
        let mut text = "format='stickslip-model/1'\n[soft]\nnormal_n_m=2e5\ntangential_n_m=1e5\ndamping_s=0.005\n[friction]\nfinger=0.4\npusher=0.2\nsupport=0\n[[effects]]\n".to_string();
        text += &format!("id = '{}'\n", info.id);
        for p in info.parameters {
            text += &format!("{} = {:?}\n", p.name, p.typical);
        }
        let file = ModelFile::parse(&text, "m").unwrap();
        assert_eq!(ModelFile::parse(&file.write(), "m").unwrap(), file);
        assert_eq!(file.to_model().effects[0], Effect::typical(info.id).unwrap());
    }
}

#[test]
fn errors_name_line_column_and_what_to_do() {
    for (from, to, place, says) in [
        ("static_friction", "static_fricton", "8:6:", "did you mean static_friction"),
        ("excess = 0.2\n", "excess = 3\n", "9:10:", "between 0 and 2"),
        ("excess = 0.2\n", "exces = 0.2\n", "7:", "lacks its parameter excess"),
        ("excess = 0.2\n", "exces = 0.2\n", "7:", "was 'exces' meant to be excess?"),
        ("intervals", "interval", "12:12:", "no parameter 'interval'"),
        ("\"hard\"", "\"stiff\"", "2:8:", "\"hard\" or \"soft\""),
        ("model/1", "model/9", "1:10:", "stickslip-model/1"),
        ("finger = 0.4", "finger = -0.4", "4:10:", "between 0 and 10"),
        ("finger = 0.4", "finger = abc", "4:10:", "a number, as 0.4"),
        ("finger = 0.4", "finger = 'abc'", "4:10:", "a number is expected"),
        ("slip_speed_m_s/b", "slip_sped_m_s/b", "18:14:", "unknown name 'slip_sped_m_s'"),
        ("\"finger2\"", "\"thumb\"", "17:10:", "thumb"),
        ("support = 0.3", "support = ", "6:", ""),
        ("low = 0,", "low = 0.5,", "19:14:", "between its low"),
    ] {
        let error = ModelFile::parse(&GOOD.replacen(from, to, 1), "m.toml").unwrap_err().to_string();
        assert!(error.starts_with(&format!("m.toml:{place}")) && error.contains(says), "{error}");
    }
}

/// A file from before a parameter was there: the advice is what makes it readable, and nothing else is needed.
#[test]
fn a_parameter_that_came_later_is_asked_for_with_the_value_that_changes_nothing() {
    let head = "format='stickslip-model/1'\nbase = 'hard'\n[friction]\nfinger=0.4\npusher=0.2\nsupport=0\n";
    let mut seen = Vec::new();
    for info in REGISTRY {
        let Some(first) = info.parameters.iter().find(|p| p.before.is_some()) else { continue };
        let mut text = format!("{head}[[effects]]\nid = '{}'\n", info.id);
        for p in info.parameters.iter().filter(|p| p.before.is_none()) {
            text += &format!("{} = {:?}\n", p.name, p.typical);
        }
        let error = ModelFile::parse(&text, "old.toml").unwrap_err().to_string();
        let says = format!("effect '{}' lacks its parameter", info.id);
        assert!(error.starts_with("old.toml:7:") && error.contains(&says), "{error}");
        assert!(error.contains(first.what), "{error}");
        let (_, advice) = error.split_once("; write ").unwrap_or_else(|| panic!("no advice: {error}"));
        for line in advice.split('`').skip(1).step_by(2) {
            text += &format!("{line}\n");
            seen.push(line.to_owned());
        }
        let file = ModelFile::parse(&text, "new.toml").unwrap_or_else(|e| panic!("{text}\n{e}"));
        for (p, value) in info.parameters.iter().zip(&file.effects[0].values) {
            assert_eq!(*value, p.before.unwrap_or(p.typical), "{} {}", info.id, p.name);
        }
    }
    for line in [
        "microslip = 0",
        "stiffening = 0",
        "pusher_rim = 0",
        "pad_torsion = 0",
        "pusher_shear = 0",
        "pad_carry = 0",
        "pusher_m_n = 0",
        "elsewhere = 1",
        "renewal_m = 0.000001",
    ] {
        assert!(seen.iter().any(|s| s == line), "{line} in {seen:?}");
    }
}

#[test]
fn expressions_follow_the_usual_precedence() {
    let x = [0.25, 0.0, 20.0, 0.0, 0.1, 0.0, 0.0, 0.0, 3.0, 20.0];
    for (text, expected) in [
        ("1 + 2*3", 7.0),
        ("(1+2)*3 - 4/2/2", 8.0),
        ("-2^2", -4.0),
        ("2^3^2", 512.0),
        ("2**-1", 0.5),
        ("1e-3 * 1E+3", 1.0),
        ("min(load_n, 7) + max(trial, 1)", 10.0),
        ("sqrt(slip_speed_m_s)", 0.5),
        ("(load_n > 10) + (load_n < 10)", 1.0),
        ("a*b + p1", 5.0 * 7.0 + 7.0),
        ("cos(pi) + abs(-1) + sign(-3)", -1.0),
        ("ln(exp(2)) - - 1", 3.0),
    ] {
        let value = evaluate(text, &["a", "b"], [5.0, 7.0, 0.0, 0.0, 0.0, 0.0], x).unwrap();
        assert!((value - expected).abs() < 1e-12, "{text} = {value}, not {expected}");
    }
}

#[test]
fn faulty_expressions_are_refused_at_the_character() {
    for (text, column) in [
        ("1 +", 4),
        ("2 * foo", 5),
        ("(1", 3),
        ("1 2", 3),
        ("1.2.3", 1),
        ("exp 2", 5),
        ("$", 1),
        ("", 1),
        ("min(1)", 6),
    ] {
        assert_eq!(parse(text, &[]).unwrap_err().column, column, "{text}");
    }
    assert!(parse(&"(".repeat(100_000), &[]).is_err());
}

#[test]
fn a_division_by_zero_is_an_error_and_not_a_number() {
    assert_eq!(evaluate("1/load_n", &[], [0.0; 6], [0.0; 10]), Err(Fault::DivisionByZero));
    assert_eq!(evaluate("ln(load_n)", &[], [0.0; 6], [0.0; 10]), Err(Fault::Domain));
    let error = parse("2 + 1/ 0", &[]).unwrap_err();
    assert_eq!((error.column, error.message.as_str()), (7, "division by zero"));
}

#[test]
fn a_formula_with_a_memory_is_read_written_and_run() {
    let text = GOOD.replace(
        "expression = \"1 + a*exp(-slip_speed_m_s/b)\"",
        "expression = \"1 + a*state\"\nstate = \"state + (load_rate_n_s - state)*dt_s/b\"",
    );
    let file = ModelFile::parse(&text, "model.toml").unwrap();
    assert_eq!(ModelFile::parse(&file.write(), "again").unwrap(), file, "{}", file.write());
    assert!(file.to_model().formulas[0].remembers());
}

#[test]
fn formulas_without_a_value_or_a_memory_are_refused_where_they_stand() {
    for (expression, says) in [
        ("1 + a*state", "state = \\\"...\\\""),
        ("1 + a/load_n + b", "divides by zero in the first step"),
        ("1 + a*ln(slip_speed_m_s/b)", "logarithm"),
        ("1 + a/0 + b", "character 7: division by zero"),
    ] {
        let text = GOOD.replace("1 + a*exp(-slip_speed_m_s/b)", expression);
        let error = ModelFile::parse(&text, "m.toml").unwrap_err().to_string();
        let says = says.replace("\\", "");
        assert!(error.starts_with("m.toml:18:14:") && error.contains(&says), "{error}");
    }
}

#[test]
fn a_formula_is_a_proposal_until_it_was_fitted() {
    let file = ModelFile::parse(GOOD, "m").unwrap();
    let (rest, proposed) = file.without_proposals();
    assert_eq!(rest.effects.iter().map(EffectEntry::name).collect::<Vec<_>>(), ["static_friction"]);
    assert_eq!(proposed.iter().map(EffectEntry::name).collect::<Vec<_>>(), ["my_hump"]);
    let mut fitted = file.clone();
    fitted.set_intervals([("friction.finger", [0.3, 0.5]), ("my_hump.a", [0.05, 0.15])]);
    assert_eq!(fitted.effects[1].intervals["a"], [0.05, 0.15]);
    assert_eq!(fitted.friction_intervals.len(), 1);
    assert_eq!(fitted.without_proposals().0, fitted);
    let written = fitted.write();
    assert_eq!(ModelFile::parse(&written, "m").unwrap(), fitted, "{written}");
}

#[test]
fn a_fit_without_intervals_writes_a_file_that_can_be_read() {
    let mut file = ModelFile::parse(GOOD, "m").unwrap();
    file.set_intervals([("my_hump.a", [f64::NAN; 2]), ("static_friction.excess", [f64::NAN; 2])]);
    assert!(!file.effects[1].is_proposal(), "part of the model: its bounds stand for the interval");
    assert_eq!(ModelFile::parse(&file.write(), "m").unwrap(), file);
}

#[test]
fn the_file_of_a_model_is_the_model_with_its_formulas() {
    let file = ModelFile::parse(GOOD, "m").unwrap();
    let again = ModelFile::of_model(&file.to_model(), &file.effects);
    assert_eq!(again.to_model(), file.to_model());
    assert_eq!(again.effects[1].name(), "my_hump");
    assert_eq!(again.effects[1].formula, file.effects[1].formula);
    let mut without = file.to_model();
    stickslip_analysis::model::candidate::remove(&mut without, 1);
    assert!(without.formulas.is_empty() && without.effects.len() == 1);
}

#[test]
fn formulas_have_names_of_their_own() {
    let error = ModelFile::parse(&GOOD.replace("my_hump", "mass_error"), "m").unwrap_err().to_string();
    assert!(error.contains("listed effect"), "{error}");
    let twice = format!("{GOOD}{}", &GOOD[GOOD.rfind("[[effects]]").unwrap()..]);
    let error = ModelFile::parse(&twice, "m").unwrap_err().to_string();
    assert!(error.contains("given to two formulas"), "{error}");
}

#[test]
fn formulas_are_read_from_a_file_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("own.toml");
    std::fs::write(&path, &GOOD[GOOD.rfind("[[effects]]").unwrap()..]).unwrap();
    let formulas = ModelFile::read_formulas(&path).unwrap();
    assert_eq!(formulas.iter().map(EffectEntry::name).collect::<Vec<_>>(), ["my_hump"]);
    std::fs::write(&path, "[[effects]]\nid = \"formula\"\n").unwrap();
    let error = ModelFile::read_formulas(&path).unwrap_err().to_string();
    assert!(error.contains("own.toml:1:1") && error.contains("name"), "{error}");
    std::fs::write(&path, "").unwrap();
    assert!(ModelFile::read_formulas(&path).unwrap_err().to_string().contains("no formula"));
}

#[test]
fn a_name_that_is_alike_is_proposed_and_others_are_not() {
    let formulas = ModelFile::parse(GOOD, "m").unwrap().effects;
    let error = |name| candidate::named(name, &formulas).unwrap_err().to_string();
    assert!(error("my_hunp").contains("did you mean my_hump"), "{}", error("my_hunp"));
    assert!(error("gripforceloss").contains("grip_force_loss"), "{}", error("gripforceloss"));
    assert!(!error("zzz").contains("mean"), "{}", error("zzz"));
    assert_eq!(candidate::named("my_hump", &formulas).unwrap(), formulas[1]);
}

/// A description is kept for the rest of the program: a notebook that diagnoses all day must not fill its memory with one.
#[test]
fn a_formula_is_described_once_however_often_it_is_asked_for() {
    let described = |text: &str| ModelFile::parse(text, "m").unwrap().effects[1].info().unwrap();
    let info = described(GOOD);
    assert!(std::ptr::eq(info, described(GOOD)));
    let other = described(&GOOD.replace("slip_speed_m_s/b", "slip_speed_m_s/b/2"));
    assert!(!std::ptr::eq(info, other) && info.summary != other.summary);
}
