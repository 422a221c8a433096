//! Texts that are nearly right: bytes cut out, doubled or replaced, members given twice, brackets without end.

use super::choices::Choices;

/// What may stand where a number, a name or a bracket was.
const INTRUDERS: [&[u8]; 24] = [
    b"0",
    b"-1",
    b"1e999",
    b"-1e999",
    b"5e-324",
    b"1.7976931348623157e308",
    b"-0.0",
    b"1e-400",
    b"NaN",
    b"null",
    b"true",
    b"\"m1\"",
    b"\"ground\"",
    b"\"\"",
    b"[]",
    b"{}",
    b"[[1]]",
    b"\"\\ud800\"",
    b"\"\\u0000\"",
    b"\xef\xbb\xbf",
    b"\xff\xfe",
    b"\xf0\x9f",
    b"\\",
    b"/*",
];

/// The text with one to four changes.
pub fn damaged(text: &str, choices: &mut Choices<'_>) -> Vec<u8> {
    let mut bytes = text.as_bytes().to_vec();
    for _ in 0..1 + choices.below(4) {
        change(&mut bytes, choices);
    }
    bytes
}

fn change(bytes: &mut Vec<u8>, choices: &mut Choices<'_>) {
    let start = (choices.fraction() * bytes.len() as f64) as usize;
    let end = (start + 1 + choices.below(40)).min(bytes.len());
    match choices.below(8) {
        0 => drop(bytes.drain(start..end)),
        1 => {
            let twice = bytes[start..end].to_vec();
            bytes.splice(end..end, twice);
        }
        2 => {
            if let Some(byte) = bytes.get_mut(start) {
                *byte = choices.byte();
            }
        }
        3 => {
            let deep = choices.pick(b"[{\"19 ");
            let many = choices.pick(&[2, 200, 20_000]);
            bytes.splice(start..start, std::iter::repeat_n(deep, many));
        }
        // A member once more, after itself.
        4 => {
            let rest = &bytes[start..];
            let from = rest.iter().position(|byte| *byte == b'"');
            let until = rest.iter().rposition(|byte| *byte == b',');
            if let (Some(from), Some(until)) = (from, until)
                && from < until
            {
                let member = rest[from..=until].to_vec();
                bytes.splice(start + from..start + from, member);
            }
        }
        // A whole token, so that the text often stays JSON.
        _ => {
            let ends = |byte: &u8| b",:[]{} \n".contains(byte);
            let token = bytes[start..].iter().position(ends).unwrap_or(0);
            let intruder = choices.pick(&INTRUDERS);
            bytes.splice(start..start + token, intruder.iter().copied());
        }
    }
}
