//! Estimated bounds, in doubles, against answers known to 34 digits.
//!
//! `cargo test --release --test certified estimated -- --nocapture` prints what each one reaches.

use std::fmt::Write as _;

use eigentone::modes::{Bounds, Precision};

use crate::known::{KNOWN, U, none_wrong, pairs};

#[test]
fn bounds_hold() {
    let mut wrong = Vec::new();
    let mut text =
        String::from("\nscene                         |λ|/u  of bound  bound/|λ|  solver\n");
    for known in KNOWN.iter() {
        let name = &known.name;
        let modes = match known.scene.system().modes_to(Precision::Double) {
            Ok(modes) => modes,
            Err(error) => {
                wrong.push(format!("{name}: {error}"));
                continue;
            }
        };
        assert_eq!(modes.bounds(), Bounds::Estimated, "{name}");
        let Some(pairs) = pairs(&known.truth, &modes) else {
            wrong.push(format!("{name}: wrong count"));
            continue;
        };
        let [mut error, mut of_bound, mut loosest] = [0.0_f64; 3];
        for pair in pairs {
            let of = |part: f64, whole: f64| if part == 0.0 { 0.0 } else { part / whole };
            error = error.max(of(pair.error, pair.size));
            let root = pair.found;
            let (Some(bound), Some(real_bound)) = (root.bound, root.real_bound) else {
                loosest = f64::INFINITY;
                continue;
            };
            loosest = loosest.max(of(bound, pair.size));
            let part = of(pair.error, bound).max(of(pair.real_error, real_bound));
            of_bound = of_bound.max(part);
            if part > 1.0 {
                wrong.push(format!(
                    "{name}: {:e} off by {:e} and {:e} in Re λ, not {bound:e} and {real_bound:e}",
                    root.value, pair.error, pair.real_error
                ));
            }
        }
        let solver = modes.plan().solver;
        let error = error / U;
        writeln!(
            text,
            "{name:25} {error:>9.1e} {of_bound:>9.2} {loosest:>10.1e}  {solver}",
        )
        .expect("strings take text");
    }
    println!("{text}");
    none_wrong(&wrong);
}
