//! temporary
use eigentone_digits::DoubleDouble;
use std::ops::{Add, Div, Mul, Neg, Sub};

pub(crate) trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    const UNIT_LOG2: i32;
    fn from_f64(x: f64) -> Self;
    fn to_f64(self) -> f64;
    fn square_root(self) -> Self;
    fn scaled(self, exponent: i32) -> Self;
    fn unit() -> f64 {
        2f64.powi(Self::UNIT_LOG2.max(-1070))
    }
}

impl Real for DoubleDouble {
    const UNIT_LOG2: i32 = -102;
    fn from_f64(x: f64) -> Self {
        DoubleDouble::from(x)
    }
    fn to_f64(self) -> f64 {
        self.to_f64()
    }
    fn square_root(self) -> Self {
        self.sqrt()
    }
    fn scaled(self, exponent: i32) -> Self {
        self * 2f64.powi(exponent)
    }
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Ball<T> {
    pub(crate) re: T,
    pub(crate) im: T,
    pub(crate) radius: f64,
}

const UP: f64 = 1.0 + 1e-12;

impl<T: Real> Ball<T> {
    pub(crate) fn exact(re: T, im: T) -> Self {
        Ball {
            re,
            im,
            radius: 0.0,
        }
    }
    pub(crate) fn from_f64(x: f64) -> Self {
        Ball::exact(T::from_f64(x), T::from_f64(0.0))
    }
    fn middle(&self) -> f64 {
        self.re.to_f64().hypot(self.im.to_f64())
    }
    pub(crate) fn upper(&self) -> f64 {
        (self.middle() + self.radius) * UP
    }
    pub(crate) fn lower(&self) -> f64 {
        (self.middle() * (2.0 - UP) - self.radius * UP).max(0.0)
    }
    pub(crate) fn scaled(self, exponent: i32) -> Self {
        Ball {
            re: self.re.scaled(exponent),
            im: self.im.scaled(exponent),
            radius: self.radius * 2f64.powi(exponent),
        }
    }
    pub(crate) fn divide(self, other: Self) -> Option<Self> {
        let low = other.lower();
        if low == 0.0 {
            return None;
        }
        let norm = other.re * other.re + other.im * other.im;
        let re = (self.re * other.re + self.im * other.im) / norm;
        let im = (self.im * other.re - self.re * other.im) / norm;
        let quotient = re.to_f64().hypot(im.to_f64()) * UP;
        let radius =
            (self.radius + quotient * other.radius) / low * UP + 32.0 * T::unit() * quotient;
        Some(Ball {
            re,
            im,
            radius: radius * UP,
        })
    }
}

impl<T: Real> Add for Ball<T> {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        let (re, im) = (self.re + other.re, self.im + other.im);
        let size = re.to_f64().abs() + im.to_f64().abs();
        Ball {
            re,
            im,
            radius: (self.radius + other.radius + 4.0 * T::unit() * size) * UP,
        }
    }
}
impl<T: Real> Neg for Ball<T> {
    type Output = Self;
    fn neg(self) -> Self {
        Ball {
            re: -self.re,
            im: -self.im,
            radius: self.radius,
        }
    }
}
impl<T: Real> Sub for Ball<T> {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}
impl<T: Real> Mul for Ball<T> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let re = self.re * other.re - self.im * other.im;
        let im = self.re * other.im + self.im * other.re;
        let (a, b) = (self.middle(), other.middle());
        let radius = a * other.radius
            + b * self.radius
            + self.radius * other.radius
            + 16.0 * T::unit() * a * b;
        Ball {
            re,
            im,
            radius: radius * UP,
        }
    }
}
