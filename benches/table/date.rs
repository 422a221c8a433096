//! The date of today.

use std::time::{SystemTime, UNIX_EPOCH};

/// Year, month and day in UTC.
pub fn today() -> String {
    const SECONDS: u64 = 86_400;
    let elapsed = SystemTime::now().duration_since(UNIX_EPOCH);
    let days = elapsed.map_or(0, |elapsed| elapsed.as_secs() / SECONDS);
    let (year, month, day) = civil(days);
    format!("{year}-{month:02}-{day:02}")
}

/// The day so many days after 1970-01-01: whole cycles of 400 years, counted from a first of March, so
/// that a leap day is the last of its year (Hinnant, *chrono-compatible low-level date algorithms*).
fn civil(days: u64) -> (u64, u64, u64) {
    /// Days from 0000-03-01 to 1970-01-01, and days of 400 years.
    const EPOCH: u64 = 719_468;
    const CYCLE: u64 = 146_097;
    let days = days + EPOCH;
    let (cycle, day) = (days / CYCLE, days % CYCLE);
    let year = (day - day / 1460 + day / 36_524 - day / (CYCLE - 1)) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    let month = (5 * day + 2) / 153;
    let of_month = day - (153 * month + 2) / 5 + 1;
    let (month, late) = if month < 10 {
        (month + 3, 0)
    } else {
        (month - 9, 1)
    };
    (400 * cycle + year + late, month, of_month)
}
