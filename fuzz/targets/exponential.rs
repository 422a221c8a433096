//! The exponential of matrices of any bits.

#![no_main]

#[path = "../../tests/random/choices.rs"]
mod choices;

use choices::Choices;
use eigentone::response::{expm, expm_condition};
use faer::Mat;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let mut choices = Choices::of(bytes);
    let n = choices.below(9);
    let columns = if choices.once_in(32) { choices.below(9) } else { n };
    // Any bits, or numbers of an ordinary size.
    let wild = choices.once_in(2);
    let entries: Vec<f64> = (0..n * columns)
        .map(|_| match wild {
            true => f64::from_bits(choices.bits()),
            false => (f64::from(choices.byte()) - 128.0) / 8.0,
        })
        .collect();
    let a = Mat::from_fn(n, columns, |i, j| entries[i + n * j]);
    let Ok(power) = expm(a.as_ref()) else {
        return;
    };
    assert_eq!(power.shape(), (n, n));
    for column in power.col_iter() {
        assert!(column.iter().all(|entry| !entry.is_nan()), "{a:?} {power:?}");
    }
    let _ = expm_condition(a.as_ref());
});
