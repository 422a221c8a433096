//! SHA-256 of FIPS 180-4, by which a page allows its script, and base64 of RFC 4648.

/// The first 32 bits after the point of a root.
fn fraction_of_root(prime: u64, degree: u32) -> u32 {
    // The largest r with r^degree ≤ prime·2^(32·degree).
    let power = |r: u128| -> bool {
        match degree {
            2 => r * r <= u128::from(prime) << 64,
            _ => r * r * r <= u128::from(prime) << 96,
        }
    };
    let mut root: u128 = 0;
    for bit in (0..37).rev() {
        if power(root | 1 << bit) {
            root |= 1 << bit;
        }
    }
    root as u32
}

pub fn digest(message: &[u8]) -> [u8; 32] {
    let primes: Vec<u64> = (2..312).filter(|n| (2..*n).all(|d| n % d != 0)).collect();
    let constants: Vec<u32> = primes.iter().map(|p| fraction_of_root(*p, 3)).collect();
    let mut state: Vec<u32> = primes[..8]
        .iter()
        .map(|p| fraction_of_root(*p, 2))
        .collect();
    let mut padded = message.to_vec();
    padded.push(0x80);
    padded.resize(padded.len().next_multiple_of(64), 0);
    if padded.len() - message.len() < 9 {
        padded.resize(padded.len() + 64, 0);
    }
    let end = padded.len() - 8;
    padded[end..].copy_from_slice(&(8 * message.len() as u64).to_be_bytes());
    for block in padded.chunks(64) {
        let words = block.chunks(4);
        let mut w: Vec<u32> = words
            .map(|word| u32::from_be_bytes(word.try_into().expect("four bytes")))
            .collect();
        for t in 16..64 {
            let (x, y) = (w[t - 15], w[t - 2]);
            let small = x.rotate_right(7) ^ x.rotate_right(18) ^ (x >> 3);
            let large = y.rotate_right(17) ^ y.rotate_right(19) ^ (y >> 10);
            let sum = large.wrapping_add(w[t - 7]).wrapping_add(small);
            w.push(sum.wrapping_add(w[t - 16]));
        }
        let mut s: [u32; 8] = state[..].try_into().expect("eight words");
        for t in 0..64 {
            let [a, b, c, _, e, f, g, h] = s;
            let sum = e.rotate_right(6) ^ e.rotate_right(11) ^ e.rotate_right(25);
            let choice = (e & f) ^ (!e & g);
            let first = h.wrapping_add(sum).wrapping_add(choice);
            let first = first.wrapping_add(constants[t]).wrapping_add(w[t]);
            let sum = a.rotate_right(2) ^ a.rotate_right(13) ^ a.rotate_right(22);
            let second = sum.wrapping_add((a & b) ^ (a & c) ^ (b & c));
            s.rotate_right(1);
            s[0] = first.wrapping_add(second);
            s[4] = s[4].wrapping_add(first);
        }
        for (old, new) in state.iter_mut().zip(s) {
            *old = old.wrapping_add(new);
        }
    }
    let bytes: Vec<u8> = state.iter().flat_map(|word| word.to_be_bytes()).collect();
    bytes.try_into().expect("32 bytes")
}

pub fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for group in bytes.chunks(3) {
        let mut all = 0u32;
        for k in 0..3 {
            all = all << 8 | u32::from(*group.get(k).unwrap_or(&0));
        }
        for k in 0..4 {
            let letter = LETTERS[(all >> (18 - 6 * k) & 63) as usize];
            out.push(if k > group.len() { '=' } else { letter as char });
        }
    }
    out
}

#[test]
fn the_digest_of_abc_is_that_of_the_standard() {
    // FIPS 180-4, example B.1.
    let found: String = digest(b"abc")
        .iter()
        .map(|byte| format!("{byte:02x}"))
        .collect();
    let wanted = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    assert_eq!(found, wanted);
}
