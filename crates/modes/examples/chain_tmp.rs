//! t
use eigentone_modes::*;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let n: usize = a[1].parse().unwrap();
    let m: usize = a[2].parse().unwrap();
    let t = Instant::now();
    let mut b = System::builder();
    let name = |i: usize| format!("m{i}");
    for i in 0..n {
        let before = if i == 0 { GROUND.to_owned() } else { name(i - 1) };
        b = b.mass(name(i), 1.0).spring(before, name(i), 1.0);
    }
    b = b.spring(name(n - 1), GROUND, 1.0);
    println!("builder {:?}", t.elapsed());
    let t = Instant::now();
    let s = b.build().unwrap();
    println!("build {:?}", t.elapsed());
    let t = Instant::now();
    let _ = s.structure().is_undamped();
    println!("structure {:?}", t.elapsed());
    let t = Instant::now();
    let r = if a.len() > 3 { SparseModes::nearest(&s, Frequency::from_radians_per_second(a[3].parse().unwrap()), m) } else { SparseModes::lowest(&s, m) };
    println!("modes {:?}", t.elapsed());
    let r = r.unwrap();
    let mut worst = 0.0f64;
    let c = std::f64::consts::PI / (2.0 * (n as f64 + 1.0));
    for (j, f) in r.frequencies().iter().enumerate() {
        let w = f.radians_per_second();
        let j = if a.len() > 3 { ((w / 2.0).asin() / c).round() } else { j as f64 + 1.0 };
        let e = 2.0 * (j * c).sin();
        worst = worst.max((w / e - 1.0).abs());
    }
    let est = r.square_bounds().iter().zip(r.squares()).map(|(b, s)| b.unwrap_or(f64::NAN) / s / 2.0).fold(0.0, f64::max);
    println!("worst {worst:e} est {est:e} counted {} {:?}", r.is_counted(), r.work());
    let st = std::fs::read_to_string("/proc/self/status").unwrap();
    for l in st.lines().filter(|l| l.starts_with("VmHWM")) { println!("{l}"); }
}
