//! What people type that is not quite what was meant, what comes of it, and colours.

use std::process::Command;

use super::{printed, refused, scene};

#[test]
fn lists_and_units_may_be_apart() {
    let three = scene("three-mass-1");
    for (together, apart) in [
        (
            &["response", &three, "--steps", "0,1,40"][..],
            &["response", &three, "--steps", "0", "1", "40"][..],
        ),
        (
            &["frf", &three, "--at", "1,0.2Hz"],
            &["frf", &three, "--at", "1", "0.2", "Hz"],
        ),
        (
            &["modes", &three, "--near", "0.18Hz", "--count", "1"],
            &["modes", "--near", "0.18", "Hz", &three, "--count", "1"],
        ),
        (
            &["frf", &three, "--at", "2,3"],
            &["frf", &three, "--at", " 2,3 rad/s"],
        ),
    ] {
        assert_eq!(printed(together), printed(apart), "{apart:?}");
    }
}

#[test]
fn slips_are_reported_with_what_would_be_right() {
    let three = scene("three-mass-1");
    for (typed, wanted) in [
        (&["modse", &three][..], "'modes'"),
        (
            &[&three],
            "a command comes before the scene, as in 'eigentone analyze ",
        ),
        (&["modes", &three, "--precison", "double"], "'--precision'"),
        (&["modes", &three, "--near", "-5"], "0 or more"),
        (&["modes", &three, "--near", "Hz"], "0 or more"),
        (&["modes", &three, "--near", "NaNHz"], "finite"),
        (&["modes", &three, "--near", "1e308Hz"], "finite"),
        (&["modes", &three, "--near", "1kHz"], "14Hz"),
        (
            &["modes", &three, "--lowest", "0"],
            "a whole number from 1 to ",
        ),
        (
            &["response", &three, "--steps", "-1"],
            "whole numbers from 0 on",
        ),
        (
            &["response", &three, "--steps", "0", "x"],
            "unexpected argument 'x'",
        ),
        (&["new", "quarter-cra"], "'quarter-car'"),
        (&["scenes", "three-mas-1"], "\"three-mass-1\""),
    ] {
        let said = refused(typed, 2);
        assert!(said.contains(wanted), "{typed:?}: {said}");
    }
}

/// Standard error is no terminal here: colours come where they are forced, but never against NO_COLOR.
#[test]
fn colours_come_where_they_are_wanted() {
    let said = |variables: &[(&str, &str)], scene: &str| {
        let output = Command::new(env!("CARGO_BIN_EXE_eigentone"))
            .args(["modes", scene])
            .env_remove("NO_COLOR")
            .env_remove("CLICOLOR_FORCE")
            .envs(variables.iter().copied())
            .output()
            .expect("the binary runs");
        String::from_utf8(output.stderr).expect("UTF-8")
    };
    // By clap, and by the program itself.
    for wrong in ["--hz", "lost.json"] {
        assert!(!said(&[], wrong).contains('\u{1b}'));
        let forced = ("CLICOLOR_FORCE", "1");
        assert!(said(&[forced], wrong).contains("\u{1b}["), "{wrong}");
        assert!(!said(&[forced, ("NO_COLOR", "1")], wrong).contains('\u{1b}'));
    }
}
