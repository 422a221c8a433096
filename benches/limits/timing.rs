//! Best times, and how they grow.

use std::time::Instant;

/// How often things run.
pub struct Runs {
    /// Once each: only the answers count.
    pub once: bool,
}

impl Runs {
    /// The best time of `body` in µs, over about a third of a second.
    pub fn best<R>(&self, mut body: impl FnMut() -> R) -> f64 {
        self.best_after(|| (), |_| body())
    }

    /// The same with something made anew for each run, which is not counted.
    pub fn best_after<S, R>(&self, make: impl Fn() -> S, mut body: impl FnMut(&mut S) -> R) -> f64 {
        let began = Instant::now();
        let mut best = f64::INFINITY;
        loop {
            let mut made = make();
            let start = Instant::now();
            std::hint::black_box(body(&mut made));
            best = best.min(start.elapsed().as_secs_f64());
            if self.once || began.elapsed().as_secs_f64() > 0.3 {
                return best * 1e6;
            }
        }
    }
}

/// The slope of log time over log size by least squares.
pub fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let logs = || points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let (mx, my) = logs().fold((0.0, 0.0), |(a, b), (x, y)| (a + x / count, b + y / count));
    let (xy, xx) = logs().fold((0.0, 0.0), |(xy, xx), (x, y)| {
        (xy + (x - mx) * (y - my), xx + (x - mx) * (x - mx))
    });
    xy / xx
}
