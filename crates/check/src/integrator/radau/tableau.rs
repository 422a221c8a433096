//! The coefficients of Radau IIA with three stages, as in the code RADAU5 of Hairer & Wanner.

/// The real eigenvalue of A⁻¹.
pub(super) const GAMMA: f64 = 3.637834252744496;

/// The complex ones are α ± iβ.
pub(super) const ALPHA: f64 = 2.6810828736277523;
pub(super) const BETA: f64 = 3.050430199247411;

const SQRT_6: f64 = 2.449489742783178;

/// The nodes.
pub(super) const C: [f64; 3] = [(4.0 - SQRT_6) / 10.0, (4.0 + SQRT_6) / 10.0, 1.0];

/// T: stages from the transformed ones, Z = T W; A⁻¹ = T Λ T⁻¹ with Λ = [γ; α −β; β α].
pub(super) const FROM_TRANSFORMED: [[f64; 3]; 3] = [
    [
        0.09123239487089295,
        -0.1412552950209542,
        -0.03002919410514742,
    ],
    [0.241717932707107, 0.20412935229379994, 0.3829421127572619],
    [0.966048182615093, 1.0, 0.0],
];

/// T⁻¹.
pub(super) const TO_TRANSFORMED: [[f64; 3]; 3] = [
    [4.325579890063155, 0.3391992518158099, 0.5417705399358749],
    [-4.178718591551905, -0.3276828207610624, 0.47662355450055044],
    [-0.5028726349457868, 2.571926949855605, -0.5960392048282249],
];

/// γ times the weights of the stages in the estimate of the error.
pub(super) const ERROR: [f64; 3] = [
    -(13.0 + 7.0 * SQRT_6) / 3.0,
    (-13.0 + 7.0 * SQRT_6) / 3.0,
    -1.0 / 3.0,
];
