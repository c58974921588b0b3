//! `must-pass.txt` names every stage of every case. A case that is removed from the code is noticed.
use rhytid_backend_cpu::Cpu;
use rhytid_conformance::{
    Suite, Verdict, cases, check_must_pass, device_label, must_pass, run_case, run_mutants, stage_name,
};
use rhytid_core::{Backend, Device, Stage};
use std::collections::BTreeSet;

#[test]
fn the_list_names_every_stage_of_every_case() {
    let mut expected: Vec<String> =
        Stage::ALL.iter().map(|&stage| format!("quick {}/mutant", stage_name(stage))).collect();
    for case in cases(Suite::Full) {
        let suite = if case.quick { "quick" } else { "full" };
        expected
            .extend(Stage::ALL.iter().map(|&stage| format!("{suite} {}/{}", stage_name(stage), case.name)));
    }
    let listed: BTreeSet<&str> =
        include_str!("../../must-pass.txt").lines().filter(|line| !line.starts_with('#')).collect();
    let missing: Vec<&String> = expected.iter().filter(|line| !listed.contains(line.as_str())).collect();
    let extra: Vec<&&str> = listed.iter().filter(|line| !expected.iter().any(|e| e == *line)).collect();
    assert!(
        missing.is_empty() && extra.is_empty(),
        "conformance/must-pass.txt is not what the code has.\nAdd:\n{}\nTake out:\n{}",
        missing.iter().map(|line| format!("{line}\n")).collect::<String>(),
        extra.iter().map(|line| format!("{line}\n")).collect::<String>()
    );
    assert_eq!(must_pass(Suite::Full).len(), expected.len(), "a name is used twice");
}

#[test]
fn a_case_taken_out_of_the_code_or_put_in_is_noticed() {
    let device = Device::open::<Cpu>(&Cpu::devices().unwrap()[0]).unwrap();
    let label = device_label(device.info());
    let mut outcomes = run_mutants(&device);
    let mut cases = cases(Suite::Quick);
    outcomes.extend(cases.iter().flat_map(|case| run_case(&device, case)));
    let whole = check_must_pass(&label, Suite::Quick, &outcomes);
    assert_eq!(whole.verdict, Verdict::Pass, "{}", whole.reason);

    for case in &cases {
        let of_case = format!("/{}", case.name);
        let mut fewer = outcomes.clone();
        fewer.retain(|outcome| !outcome.name.ends_with(&of_case));
        assert_eq!(fewer.len() + 6, outcomes.len());
        let outcome = check_must_pass(&label, Suite::Quick, &fewer);
        assert_eq!(outcome.verdict, Verdict::Fail, "{} can be taken out", case.name);
        assert!(outcome.reason.contains(&format!("normals/{}", case.name)), "{}", outcome.reason);
    }
    let one_stage_less = &outcomes[..outcomes.len() - 1];
    assert_eq!(check_must_pass(&label, Suite::Quick, one_stage_less).verdict, Verdict::Fail);
    // The full suite requires more than the quick one reports.
    assert_eq!(check_must_pass(&label, Suite::Full, &outcomes).verdict, Verdict::Fail);

    let mut new = cases.remove(0);
    new.name = "new".into();
    let mut more = outcomes.clone();
    more.extend(run_case(&device, &new));
    let outcome = check_must_pass(&label, Suite::Quick, &more);
    assert_eq!(outcome.verdict, Verdict::Fail);
    assert!(outcome.reason.contains("not in must-pass.txt"), "{}", outcome.reason);
    let mut twice = outcomes.clone();
    twice.extend_from_slice(&outcomes[..1]);
    assert!(check_must_pass(&label, Suite::Quick, &twice).reason.contains("twice"));
}
