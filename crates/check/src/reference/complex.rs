//! Complex numbers as pairs of balls.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::ball::Ball;

/// A complex number, each part of which is known to within its radius.
#[derive(Clone, Debug)]
pub(super) struct Complex {
    pub(super) re: Ball,
    pub(super) im: Ball,
}

impl Complex {
    pub(super) fn real(re: Ball) -> Complex {
        Complex {
            re,
            im: Ball::zero(),
        }
    }

    pub(super) fn midpoint(&self) -> Complex {
        Complex {
            re: self.re.midpoint(),
            im: self.im.midpoint(),
        }
    }

    pub(super) fn rounded(&self, bits: u64) -> Complex {
        Complex {
            re: self.re.rounded(bits),
            im: self.im.rounded(bits),
        }
    }

    pub(super) fn conjugate(self) -> Complex {
        Complex {
            re: self.re,
            im: -self.im,
        }
    }

    pub(super) fn contains_zero(&self) -> bool {
        self.re.contains_zero() && self.im.contains_zero()
    }

    /// |z|.
    pub(super) fn modulus(&self) -> Ball {
        (&self.re * &self.re + &self.im * &self.im).sqrt()
    }

    /// log₂|z| of the midpoint, to within a half; −∞ for 0.
    pub(super) fn log2(&self) -> f64 {
        self.re.log2().max(self.im.log2())
    }

    /// The same number with at least so many bits for what is computed from it.
    pub(super) fn with_at_least(self, bits: u64) -> Complex {
        let more = |part: Ball| {
            let bits = part.bits().max(bits);
            part.with_bits(bits)
        };
        Complex {
            re: more(self.re),
            im: more(self.im),
        }
    }

    /// One of the two roots: of z = a + bi, √((|z| + |a|)/2) is one part up to its sign, and |b|
    /// divided by twice that the other.
    pub(super) fn sqrt(&self) -> Complex {
        let larger = (self.modulus() + self.re.abs()).scaled(-1).sqrt();
        let other = (&self.im / &larger).scaled(-1);
        match self.re.is_positive() {
            true => Complex {
                re: larger,
                im: other,
            },
            false => Complex {
                re: other,
                im: larger,
            },
        }
    }
}

impl Add for &Complex {
    type Output = Complex;
    fn add(self, other: &Complex) -> Complex {
        Complex {
            re: &self.re + &other.re,
            im: &self.im + &other.im,
        }
    }
}

impl Sub for &Complex {
    type Output = Complex;
    fn sub(self, other: &Complex) -> Complex {
        Complex {
            re: &self.re - &other.re,
            im: &self.im - &other.im,
        }
    }
}

impl Mul for &Complex {
    type Output = Complex;
    fn mul(self, other: &Complex) -> Complex {
        Complex {
            re: &self.re * &other.re - &self.im * &other.im,
            im: &self.re * &other.im + &self.im * &other.re,
        }
    }
}

impl Div for &Complex {
    type Output = Complex;
    fn div(self, other: &Complex) -> Complex {
        let square = &other.re * &other.re + &other.im * &other.im;
        let product = self * &other.clone().conjugate();
        Complex {
            re: product.re / &square,
            im: product.im / square,
        }
    }
}

impl Neg for Complex {
    type Output = Complex;
    fn neg(self) -> Complex {
        Complex {
            re: -self.re,
            im: -self.im,
        }
    }
}
