//! eigentone
fn main() {}
