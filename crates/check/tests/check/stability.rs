//! The stability study at three values of each family.

use eigentone_check::{Cell, Family, StabilityStudy, Verdict};

fn study() -> StabilityStudy {
    let mut families = Family::all();
    for family in &mut families {
        let last = *family.values.last().expect("a family has values");
        family.values = match family.name {
            "size" => vec![1.0, 10.0, 30.0],
            // A middle that takes no time, so that no machine leaves it out.
            "horizon" => vec![1.0, 100.0, last],
            _ => vec![family.values[0], family.values[4], last],
        };
    }
    let mut cells = 0;
    let study = StabilityStudy::run(&families, &mut |progress| {
        assert_eq!(progress.done, cells);
        cells += 1;
        assert!(cells <= progress.total);
    });
    let rows = study.families.iter().flat_map(|family| &family.rows);
    assert_eq!(cells, rows.map(|row| row.cells.len()).sum::<usize>());
    study
}

/// What the plan picks is accurate wherever a family ends, with bounds to the last digit; others fail
/// somewhere, and every failure is explained.
#[test]
fn the_plan_holds_to_the_ends() {
    let study = study();
    assert_eq!(study.families.len(), 6);
    for found in &study.families {
        for row in &found.rows {
            let what = format!("{}, {}: {:?}", found.family.name, row.method, row.cells);
            if row.planned && row.method == "plan" {
                for cell in &row.cells {
                    assert!(
                        matches!(cell, Cell::Answered { error, .. } if *error <= 1.2e-16),
                        "{what}"
                    );
                }
            }
            if row.planned {
                let accurate = |cell: &Cell| cell.verdict() == Verdict::Accurate;
                assert!(row.cells.iter().all(accurate), "{what}");
            }
            let worst = |cell: &Cell| cell.verdict() != Verdict::Accurate;
            assert_eq!(
                row.explanation.is_some(),
                row.cells.iter().any(worst),
                "{what}"
            );
        }
    }
    let verdicts = |family: &str, method: &str| -> Vec<Verdict> {
        let mut families = study.families.iter();
        let found = families.find(|found| found.family.name == family);
        let found = found.expect("a family");
        let row = found.rows.iter().find(|row| row.method.starts_with(method));
        let cells = row.expect("a method").cells.iter();
        cells.map(Cell::verdict).collect()
    };
    use Verdict::{Accurate, Broken, NotRun};
    // Theory: a fixed explicit step is unstable beyond 2.8/|λ|, an adaptive one takes forever, an implicit one
    // stays stable; the matrices of all of them are rounded.
    assert_eq!(verdicts("stiffness", "Runge"), [Accurate, Broken, Broken]);
    assert_eq!(verdicts("stiffness", "DOP853")[2], NotRun);
    assert_eq!(verdicts("damping", "Newmark"), [Accurate; 3]);
    assert_eq!(verdicts("mass", "Newmark"), [Accurate; 3]);
    assert_eq!(verdicts("stiffness", "exponential")[2], Broken);
    assert_eq!(verdicts("horizon", "DOP853"), [Accurate, Accurate, NotRun]);
}
