//! Scene files: what is read, what is refused, and in which words.

use std::path::{Path, PathBuf};
use std::process::Command;

use boon::{Compiler, SchemaIndex, Schemas};
use eigentone::gallery::cases;
use eigentone::response::Load;
use eigentone::scene::{Scene, SceneError};
use proptest::prelude::*;
use serde_json::{Value, json};

const FILE: &str = "scene.json";

fn parse(text: &str) -> Result<Scene, SceneError> {
    Scene::parse(text, Path::new(FILE))
}

/// A scene of two masses with these members beside `masses` and `springs`.
fn two_masses(members: &str) -> String {
    let comma = if members.is_empty() { "" } else { "," };
    format!(
        r#"{{ "masses": [{{"name": "m1", "mass": 2}}, {{"name": "m2", "mass": 1}}],
"springs": [{{"between": ["ground", "m1"], "stiffness": 2}}, {{"between": ["m1", "m2"], "stiffness": 0.2}}]{comma}
{members} }}"#
    )
}

fn loads(list: &str) -> String {
    two_masses(&format!(
        r#""loads": [{list}], "time": {{"end": 10, "step": 0.1}}"#
    ))
}

/// Two masses on a road that moves, with these members beside.
fn road(members: &str) -> String {
    format!(
        r#"{{ "masses": [{{"name": "body", "mass": 2}}, {{"name": "wheel", "mass": 1}}], "supports": ["road"],
"springs": [{{"between": ["wheel", "body"], "stiffness": 2, "name": "spring"}}, {{"between": ["road", "wheel"], "stiffness": 9, "name": "tyre"}}],
{members} }}"#
    )
}

fn points(list: &str) -> String {
    road(&format!(r#""points": [{list}]"#))
}

fn motions(list: &str) -> String {
    road(&format!(
        r#""motions": [{list}], "time": {{"end": 10, "step": 0.5}}"#
    ))
}

fn outputs(list: &str) -> String {
    road(&format!(r#""outputs": [{list}]"#))
}

fn noise(list: &str) -> String {
    road(&format!(r#""noise": [{list}]"#))
}

/// Samples of a file as the motion of a support.
fn record(file: &str) -> String {
    motions(&format!(
        r#"{{"of": "road", "acceleration": {{"samples": {{"step": 0.5, "values": {file}, "hold": "first"}}}}}}"#
    ))
}

/// A beam with one of its members in place of the right one.
fn beam(member: &str) -> String {
    let right = [
        ("length", "1"),
        ("elements", "2"),
        ("flexural_rigidity", "1"),
        ("mass_per_length", "1"),
        ("ends", r#"["clamped", "free"]"#),
    ];
    let others = right
        .iter()
        .filter(|(key, _)| !member.starts_with(&format!("{key:?}")));
    let others: Vec<String> = others
        .map(|(key, value)| format!("{key:?}: {value}"))
        .collect();
    format!(
        r#"{{"beams": [{{"name": "b", {member}, {}}}]}}"#,
        others.join(", ")
    )
}

/// Two masses on soil, held by springs or only joined by them, with damping of the whole.
fn damped(damping: &str, pushed: bool) -> String {
    let stiffness = if pushed { -1 } else { 1 };
    let joint = if pushed { "a" } else { "soil" };
    format!(
        r#"{{"masses": [{{"name": "a", "mass": 1}}, {{"name": "b", "mass": 1}}], "supports": ["soil"],
        "springs": [{{"between": ["{joint}", "b"], "stiffness": {stiffness}}}, {{"between": ["a", "b"], "stiffness": {stiffness}}}],
        "damping": {{{damping}}}}}"#
    )
}

fn one_mass(mass: &str) -> String {
    format!("{{ \"masses\": [\n{mass} ] }}")
}

fn one_spring(spring: &str) -> String {
    format!(
        r#"{{ "masses": [{{"name": "left", "mass": 1}}, {{"name": "right", "mass": 1}}], "springs": [
{spring} ] }}"#
    )
}

/// Two nodes joined by an element, the second one without mass.
fn massless(element: &str, members: &str) -> String {
    format!(
        r#"{{ "masses": [{{"name": "a", "mass": 1}}, {{"name": "p", "mass": 0}}],
{element},
{members} }}"#
    )
}

/// Who can see that a scene is wrong.
#[derive(Clone, Copy, PartialEq)]
enum Seen {
    /// The reader and the schema.
    ByBoth,
    /// The reader alone: names, sums, repeated keys and the fit of numbers to each other.
    ByReader,
    /// It is no JSON, so that the schema has nothing to look at.
    AsText,
}
use Seen::*;

/// A wrong scene, the place that the message must name, and a part of what it must say.
struct Bad {
    text: String,
    place: &'static str,
    says: &'static str,
    seen: Seen,
}

fn bad(text: impl Into<String>, place: &'static str, says: &'static str, seen: Seen) -> Bad {
    Bad {
        text: text.into(),
        place,
        says,
        seen,
    }
}

#[rustfmt::skip]
fn bad_scenes() -> Vec<Bad> {
    let spring = r#""springs": [{"between": ["p", "a"], "stiffness": 1}]"#;
    let damper = r#""dampers": [{"between": ["p", "a"], "damping": 1}]"#;
    vec![
        // Text
        bad("", "", "is empty", AsText),
        bad(" \n", "", "is empty", AsText),
        bad("{ \"masses\": [\n", "2:1: masses", "ends too early", AsText),
        bad("{} {}", "1:4", "nothing may follow the scene", AsText),
        bad(two_masses(r#""time": {"end": 1, "step": 0.1},"#), "3:34", "one too many", AsText),
        bad("// two masses\n{}", "1:1", "here should be", AsText),
        bad("{ \"title\": \"a\nb\" }", "2:1: title", "control character", AsText),
        bad(one_mass(r#"{"name": "m", "mass": NaN}"#), "2:23: masses[0].mass", "NaN is not a finite number", AsText),
        bad(one_mass(r#"{"name": "m", "mass": -Infinity}"#), "2:24: masses[0].mass", "-Infinity is not a finite number", AsText),
        bad(one_mass(r#"{"name": "m", "mass": 1e999}"#), "2:27: masses[0].mass", "1e999 is not a finite number", AsText),
        bad(one_mass(r#"{"name": "m", "mass": +1}"#), "2:23: masses[0].mass", "is not JSON", AsText),
        bad(one_mass(r#"{"name": "m", "mass": 1,5}"#), "2:25: masses[0]", "here should be a key", AsText),
        bad("[".repeat(100_000), "1:1", "expected an object, found a list", AsText),
        bad(format!("{{\"title\": {}", "[".repeat(100_000)), "1:11: title", "expected a text in quotes, found a list", AsText),
        // Keys
        bad("[]", "1:2", "expected an object, found a list", ByBoth),
        bad("null", "1:4", "expected an object, found null", ByBoth),
        bad("{}", "1:1", "give at least one mass or a matrix", ByBoth),
        bad(r#"{"springs": []}"#, "1:1", "give at least one mass or a matrix", ByBoth),
        bad(two_masses(r#""spring": []"#), "3:8: spring", "did you mean \"springs\"?", ByBoth),
        bad(one_spring(r#"{"between": ["left", "right"], "stifness": 2}"#), "2:41: springs[0].stifness", "did you mean \"stiffness\"?", ByBoth),
        bad(one_spring(r#"{"between": ["left", "right"], "stiffness": 2, "colour": 1}"#), "2:55: springs[0].colour", "known are \"between\", \"stiffness\", \"name\" and \"loss_factor\"", ByBoth),
        bad(two_masses(r#""initial": {"m1": {"position": 1}}"#), "3:29: initial.m1.position", "known are \"displacement\" and \"velocity\"", ByBoth),
        bad(format!("{{ {:?}: 1 }}", "k".repeat(100_000)), "1:100004: kkk", "…\" is unknown", ByBoth),
        bad(one_mass(r#"{"name": "m"}"#), "2:13: masses[0]", "the key \"mass\" is missing", ByBoth),
        bad(two_masses(r#""time": {"end": 3}"#), "3:18: time", "the key \"step\" is missing", ByBoth),
        bad(loads(r#"{"on": "m1", "samples": {"step": 1, "values": [1]}}"#), "loads[0].samples", "the key \"hold\" is missing", ByBoth),
        bad(loads(r#"{"step": {"force": 1}}"#), "loads[0]", "the key \"on\" is missing", ByBoth),
        bad(two_masses(r#""springs": []"#), "3:9: springs", "the key \"springs\" is here twice", ByReader),
        bad(two_masses(r#""time": {"end": 1, "step": 0.1, "end": 1}"#), "3:37: time.end", "here twice", ByReader),
        bad(one_mass(r#"{"name": "m", "mass": 1, "mass": 1}"#), "2:31: masses[0].mass", "here twice", ByReader),
        bad(two_masses(r#""initial": {"m1": {}, "m1": {}}"#), "3:26: initial.m1", "the key \"m1\" is here twice", ByReader),
        bad(two_masses(r#""initial": {"m1": {"velocity": 1, "velocity": 1}}"#), "initial.m1.velocity", "here twice", ByReader),
        bad(r#"{"matrices": {"mass": [[1]], "mass": [[1]]}}"#, "matrices.mass", "here twice", ByReader),
        bad(loads(r#"{"on": "m1", "step": {"force": 1}, "step": {"force": 1}}"#), "loads[0].step", "here twice", ByReader),
        // Kinds of values
        bad(one_mass(r#"{"name": "m", "mass": "1"}"#), "2:25: masses[0].mass", "expected a number, found the text \"1\"", ByBoth),
        bad(one_mass(r#"{"name": "m", "mass": true}"#), "masses[0].mass", "expected a number, found true", ByBoth),
        bad(one_mass(r#"{"name": "m", "mass": null}"#), "masses[0].mass", "expected a number, found null", ByBoth),
        bad(one_mass(r#"{"name": 1, "mass": 1}"#), "masses[0].name", "expected a text in quotes, found the number 1", ByBoth),
        bad(one_mass(r#"["m", 1]"#), "masses[0]", "expected an object, found a list", ByBoth),
        bad(r#"{"masses": {"m": 1}}"#, "1:12: masses", "expected a list, found an object", ByBoth),
        bad(two_masses(r#""title": null"#), "title", "found null", ByBoth),
        bad(two_masses(r#""dampers": null"#), "dampers", "found null", ByBoth),
        bad(two_masses(r#""initial": null"#), "initial", "found null", ByBoth),
        bad(two_masses(r#""time": null"#), "time", "found null", ByBoth),
        bad(two_masses(r#""time": [1, 0.1]"#), "time", "expected an object, found a list", ByBoth),
        bad(loads(r#"{"on": "m1", "samples": {"step": 1, "values": [1, null], "hold": "zero"}}"#), "loads[0].samples.values[1]", "expected a number, found null", ByBoth),
        bad(loads(r#"{"on": "m1", "samples": {"step": 1, "values": [1], "hold": "linear"}}"#), "loads[0].samples.hold", "expected \"zero\" or \"first\", found the text \"linear\"", ByBoth),
        bad(loads(r#"{"on": "m1", "samples": {"step": 1, "values": [1], "hold": {"zero": null}}}"#), "loads[0].samples.hold", "expected \"zero\" or \"first\", found an object", ByBoth),
        bad(one_spring(r#"{"between": ["left"], "stiffness": 1}"#), "springs[0].between", "expected a list of two names, found a list of 1", ByBoth),
        bad(one_spring(r#"{"between": ["left", "right", "ground"], "stiffness": 1}"#), "springs[0].between", "found a list of 3", ByBoth),
        bad(one_spring(r#"{"between": ["left", 2], "stiffness": 1}"#), "springs[0].between[1]", "expected a text in quotes", ByBoth),
        bad(one_spring(r#"{"between": "left", "stiffness": 1}"#), "springs[0].between", "expected a list of two names, found the text \"left\"", ByBoth),
        // Names
        bad(one_mass(r#"{"name": "m", "mass": 1}, {"name": "m", "mass": 1}"#), "2:36: masses[1].name", "masses 0 and 1 are both named \"m\"", ByReader),
        bad(one_mass(r#"{"name": "ground", "mass": 1}"#), "2:10: masses[0].name", "reserved", ByBoth),
        bad(one_mass(r#"{"name": "", "mass": 1}"#), "2:10: masses[0].name", "is empty", ByBoth),
        bad(one_spring(r#"{"between": ["left", "rihgt"], "stiffness": 1}"#), "2:22: springs[0].between[1]", "did you mean \"right\"?", ByReader),
        bad(one_spring(r#"{"between": ["Ground", "left"], "stiffness": 1}"#), "2:14: springs[0].between[0]", "did you mean \"ground\"?", ByReader),
        bad(one_spring(r#"{"between": ["m9", "left"], "stiffness": 1}"#), "2:14: springs[0].between[0]", "known are \"left\", \"right\" and \"ground\"", ByReader),
        bad(one_spring(r#"{"between": ["left", "left"], "stiffness": 1}"#), "2:13: springs[0].between", "its ends must differ", ByBoth),
        bad(one_spring(r#"{"between": ["ground", "ground"], "stiffness": 1}"#), "2:13: springs[0].between", "its ends must differ", ByBoth),
        bad(two_masses(r#""dampers": [{"between": ["m1", "m3"], "damping": 1}]"#), "3:32: dampers[0].between[1]", "known are \"m1\", \"m2\" and \"ground\"", ByReader),
        bad(two_masses(r#""initial": {"m3": {"displacement": 1}}"#), "3:19: initial.m3", "known are \"m1\" and \"m2\"", ByReader),
        bad(two_masses(r#""initial": {"left side": {}}"#), "3:26: initial[\"left side\"]", "is not the name of a coordinate", ByReader),
        bad(two_masses(r#""initial": {"ground": {"displacement": 1}}"#), "initial.ground", "the ground does not move", ByBoth),
        bad(loads(r#"{"on": "m", "step": {"force": 1}}"#), "3:18: loads[0].on", "known are \"m1\" and \"m2\"", ByReader),
        bad(loads(r#"{"on": "ground", "step": {"force": 1}}"#), "3:18: loads[0].on", "the ground does not move", ByBoth),
        // Numbers
        bad(one_mass(r#"{"name": "m", "mass": -1}"#), "2:23: masses[0].mass", "must be a finite number ≥ 0", ByBoth),
        bad(two_masses(r#""time": {"end": 1, "step": 0}"#), "3:28: time.step", "greater than 0", ByBoth),
        bad(two_masses(r#""time": {"end": 1, "step": -0.1}"#), "time.step", "greater than 0", ByBoth),
        bad(two_masses(r#""time": {"end": -1, "step": 0.1}"#), "3:17: time.end", "0 or later", ByBoth),
        bad(two_masses(r#""time": {"end": 1e300, "step": 0.1}"#), "3:9: time", "more than 2^53 steps", ByReader),
        bad(r#"{"masses": [{"name": "m", "mass": 1}], "springs": [{"between": ["ground", "m"], "stiffness": 1.7e308},
            {"between": ["ground", "m"], "stiffness": 1.7e308}]}"#, "1:51: springs", "overflows", ByReader),
        // Matrices
        bad(r#"{"masses": []}"#, "1:12: masses", "give at least one mass", ByBoth),
        bad(r#"{"masses": [], "matrices": {"mass": [[1]]}}"#, "1:12: masses", "give at least one mass", ByBoth),
        bad(r#"{"matrices": {}}"#, "1:14: matrices", "give at least one mass or a matrix", ByReader),
        bad(r#"{"matrices": {"mass": []}}"#, "matrices", "give at least one mass or a matrix", ByBoth),
        bad(r#"{"matrices": {"mass": [[]]}}"#, "matrices.mass", "1 × 0", ByBoth),
        bad(r#"{"matrices": {"mass": [1, 0]}}"#, "matrices.mass[0]", "expected a list, found the number 1", ByBoth),
        bad(r#"{"matrices": {"mass": [[1, "0"], [0, 1]]}}"#, "matrices.mass[0][1]", "expected a number", ByBoth),
        bad(r#"{"matrices": {"mass": [[1, 0], [0]]}}"#, "1:32: matrices.mass[1]", "rows must be equally long", ByReader),
        bad(r#"{"matrices": {"mass": [[1, 0]]}}"#, "1:23: matrices.mass", "1 × 2: it must be 2 × 2", ByReader),
        bad(r#"{"matrices": {"mass": [[1]], "stiffness": [[1, 0], [0, 1]]}}"#, "1:43: matrices.stiffness", "2 × 2: it must be 1 × 1", ByReader),
        bad(two_masses(r#""matrices": {"damping": [[1]]}"#), "3:25: matrices.damping", "1 × 1: it must be 2 × 2", ByReader),
        bad(r#"{"matrices": {"mass": "mass.mtx"}}"#, "1:23: matrices.mass", "mass.mtx: cannot be read", ByReader),
        bad(r#"{"matrices": {"K": [[1]]}}"#, "matrices.K", "known are \"mass\", \"damping\" and \"stiffness\"", ByBoth),
        bad(r#"{"matrices": {"mass": [[1]]}, "initial": {"x2": {}}}"#, "1:49: initial.x2", "known is \"x1\"", ByReader),
        bad(r#"{"matrices": {"mass": [[1]]}, "springs": [{"between": ["x1", "x2"], "stiffness": 1}]}"#, "springs[0].between[1]", "known are \"x1\" and \"ground\"", ByReader),
        // Massless nodes
        bad(massless(spring, r#""initial": {"p": {"displacement": 1}}"#), "3:18: initial.p", "no initial state", ByReader),
        bad(massless(spring, r#""initial": {"p": {}}"#), "3:18: initial.p", "no initial state", ByReader),
        bad(massless(damper, r#""initial": {"p": {"velocity": 1}}"#), "3:31: initial.p.velocity", "no initial velocity", ByReader),
        bad(massless(spring, r#""loads": [{"on": "p", "impulse": {"magnitude": 1}}]"#), "3:34: loads[0].impulse", "neither mass nor damper", ByReader),
        // Loads
        bad(loads(r#"{"on": "m1"}"#), "3:11: loads[0]", "the load has no force: give it one of \"step\", \"ramp\"", ByBoth),
        bad(loads(r#"{"on": "m1", "step": {"force": 1}, "ramp": {"rate": 1}}"#), "3:11: loads[0]", "has \"step\" and \"ramp\"", ByBoth),
        bad(loads(r#"{"on": "m1", "pulse": {"force": 1}}"#), "loads[0].pulse", "known are \"on\", \"step\", \"ramp\", \"impulse\"", ByBoth),
        bad(loads(r#"{"on": "m1", "impulse": {"magnitude": 1, "at": -1}}"#), "3:58: loads[0].impulse.at", "must not come before 0", ByBoth),
        bad(two_masses(r#""loads": [{"on": "m1", "impulse": {"magnitude": 1, "at": -1}}]"#), "3:58: loads[0].impulse.at", "must not come before 0", ByBoth),
        bad(loads(r#"{"on": "m1", "samples": {"step": 0.1, "values": [], "hold": "zero"}}"#), "loads[0].samples.values", "at least one sample", ByBoth),
        bad(loads(r#"{"on": "m1", "samples": {"step": 0, "values": [1], "hold": "zero"}}"#), "loads[0].samples.step", "greater than 0", ByBoth),
        bad(two_masses(r#""loads": [{"on": "m1", "samples": {"step": -1, "values": [1], "hold": "zero"}}]"#), "loads[0].samples.step", "greater than 0", ByBoth),
        bad(loads(r#"{"on": "m1", "samples": {"step": 0.15, "values": [1], "hold": "zero"}}"#), "3:44: loads[0].samples.step", "times or divided by a whole number", ByReader),
        bad(loads(r#"{"on": "m1", "half_sine": {"force": 1}}"#), "loads[0].half_sine", "the key \"duration\" is missing", ByBoth),
        bad(loads(r#"{"on": "m1", "samples": {"step": 1, "values": 1, "hold": "zero"}}"#), "loads[0].samples.values", "expected a list of numbers, or an object with \"file\" and \"column\", found the number 1", ByBoth),
        // Points and supports
        bad(points(r#"{"name": "p", "moves": {"bodi": 1}}"#), "3:44: points[0].moves.bodi", "did you mean \"body\"?", ByReader),
        bad(points(r#"{"name": "p", "moves": {"p": 1}}"#), "3:41: points[0].moves.p", "point \"p\" moves with itself", ByReader),
        bad(points(r#"{"name": "p", "moves": {"q": 1}}, {"name": "q", "moves": {"p": 1}}"#), "points[0].moves.q", "points \"p\" and \"q\" move with each other", ByReader),
        bad(points(r#"{"name": "p", "moves": {"ground": 1}}"#), "points[0].moves.ground", "is not the name of a coordinate or support", ByBoth),
        bad(points(r#"{"name": "p", "moves": {}}"#), "points[0].moves", "moves with nothing", ByBoth),
        bad(points(r#"{"name": "p", "moves": {"body": null}}"#), "points[0].moves.body", "expected a number", ByBoth),
        bad(points(r#"{"name": "p", "moves": {"body": 1, "body": 2}}"#), "points[0].moves.body", "here twice", ByReader),
        bad(points(r#"{"name": "p", "moves": {"body": 1}, "mass": -1}"#), "3:56: points[0].mass", "finite number ≥ 0", ByBoth),
        bad(points(r#"{"name": "body", "moves": {"wheel": 1}}"#), "3:21: points[0].name", "a name of its own", ByReader),
        bad(points(r#"{"name": "ground", "moves": {"wheel": 1}}"#), "points[0].name", "a name of its own", ByBoth),
        bad(points(r#"{"name": "", "moves": {"wheel": 1}}"#), "points[0].name", "a name of its own", ByBoth),
        bad(points(r#"{"moves": {"wheel": 1}}"#), "points[0]", "the key \"name\" is missing", ByBoth),
        bad(two_masses(r#""supports": ["s", "s"]"#), "3:19: supports[1]", "a name of its own", ByReader),
        bad(two_masses(r#""supports": ["ground"]"#), "3:14: supports[0]", "a name of its own", ByBoth),
        bad(two_masses(r#""supports": [{"name": "s"}]"#), "supports[0]", "expected a text in quotes", ByBoth),
        bad(points(r#"{"name": "p", "moves": {"body": 1}}], "initial": {"p": {"displacement": 1}}, "loads": ["#), "3:67: initial.p", "\"p\" is a point: name a coordinate, such as those it moves with", ByReader),
        bad(road(r#""initial": {"road": {}}"#), "3:21: initial.road", "supports are at rest", ByReader),
        bad(road(r#""loads": [{"on": "road", "step": {"force": 1}}]"#), "3:18: loads[0].on", "moves nothing", ByReader),
        bad(road(r#""loads": [{"on": "rode", "step": {"force": 1}}]"#), "3:18: loads[0].on", "is not the name of a coordinate or point", ByReader),
        bad(one_mass(r#"{"name": "m", "mass": 1, "unit": "deg"}"#), "masses[0].unit", "expected \"m\" or \"rad\"", ByBoth),
        // Motions
        bad(motions(r#"{"of": "raod", "displacement": {"step": {"height": 1}}}"#), "3:20: motions[0].of", "did you mean \"road\"?", ByReader),
        bad(motions(r#"{"of": "body", "displacement": {"step": {"height": 1}}}"#), "3:20: motions[0].of", "\"body\" is a coordinate: name a support", ByReader),
        bad(motions(r#"{"of": "ground", "displacement": {"step": {"height": 1}}}"#), "motions[0].of", "the ground does not move", ByBoth),
        bad(motions(r#"{"of": "road"}"#), "3:13: motions[0]", "the motion says nothing: give it one of \"displacement\"", ByBoth),
        bad(motions(r#"{"of": "road", "displacement": {}}"#), "3:44: motions[0].displacement", "the motion has no course: give it one of \"step\"", ByBoth),
        bad(motions(r#"{"of": "road", "displacement": {"step": {"height": 1}, "ramp": {"rate": 1}}}"#), "motions[0].displacement", "has \"step\" and \"ramp\"", ByBoth),
        bad(motions(r#"{"of": "road", "displacement": {"step": {"height": 1}}, "velocity": {"step": {"height": 1}}}"#), "motions[0]", "has \"displacement\" and \"velocity\"", ByBoth),
        bad(motions(r#"{"of": "road", "displacement": {"step": {"force": 1}}}"#), "motions[0].displacement.step.force", "known are \"height\" and \"start\"", ByBoth),
        bad(motions(r#"{"of": "road", "displacement": {"impulse": {"magnitude": 1}}}"#), "motions[0].displacement.impulse", "is unknown", ByBoth),
        // Files of samples
        bad(record(r#"{"file": "nowhere.csv"}"#), "motions[0].acceleration.samples.values", "nowhere.csv: cannot be read", ByReader),
        bad(record(r#"{"file": "."}"#), "motions[0].acceleration.samples.values", ".: is not a file", ByReader),
        bad(record(r#"{"column": 1}"#), "motions[0].acceleration.samples.values", "the key \"file\" is missing", ByBoth),
        bad(record(r#"{"file": "tests/scene/record.csv", "column": 0}"#), "samples.values.column", "its number, from 1 on, found the number 0", ByBoth),
        bad(record(r#"{"file": "tests/scene/record.csv", "column": 1.5}"#), "samples.values.column", "its number, from 1 on, found the number 1.5", ByBoth),
        bad(record(r#"{"file": "tests/scene/record.csv", "column": 3}"#), "samples.values", "record.csv:2:1: there is no column 3: the file has 2 columns", ByReader),
        bad(record(r#"{"file": "tests/scene/record.csv", "column": "ax"}"#), "samples.values", "record.csv:2:1: there is no column named \"ax\": known are \"t [s]\" and \"ax [m/s2]\"", ByReader),
        bad(record(r#"{"file": "tests/scene/record.csv"}"#), "samples.values", "say which by \"column\"", ByReader),
        // Outputs
        bad(outputs(r#"{"name": "o"}"#), "3:13: outputs[0]", "the output shows nothing: give it one of \"displacement\"", ByBoth),
        bad(outputs(r#"{"name": "o", "displacement": {"body": 1}, "force": "tyre"}"#), "outputs[0]", "has \"displacement\" and \"force\"", ByBoth),
        bad(outputs(r#"{"name": "o", "displacement": {}}"#), "outputs[0].displacement", "the sum is empty", ByBoth),
        bad(outputs(r#"{"name": "o", "velocity": "body"}"#), "outputs[0].velocity", "expected an object whose keys are names, as {\"m1\": …}, found the text \"body\"", ByBoth),
        bad(outputs(r#"{"name": "o", "velocity": {"boy": 1}}"#), "3:47: outputs[0].velocity.boy", "did you mean \"body\"?", ByReader),
        bad(outputs(r#"{"name": "o", "force": "tire"}"#), "3:36: outputs[0].force", "did you mean \"tyre\"?", ByReader),
        bad(outputs(r#"{"name": "o", "force": "body"}"#), "outputs[0].force", "is not the name of a spring or damper: known are \"spring\" and \"tyre\"", ByReader),
        bad(outputs(r#"{"name": "o", "force": "tyre"}, {"name": "o", "force": "tyre"}"#), "outputs[1].name", "must differ", ByReader),
        bad(outputs(r#"{"name": "", "force": "tyre"}"#), "outputs[0].name", "must not be empty", ByBoth),
        // Noise
        bad(noise(r#"{"on": "body"}"#), "3:11: noise[0]", "the noise has no density: give it one of \"force\"", ByBoth),
        bad(noise(r#"{"on": "body", "force": 1, "velocity": 1}"#), "noise[0]", "give each a noise of its own", ByBoth),
        bad(noise(r#"{"of": "road", "force": 1}"#), "noise[0]", "a force is noise \"on\" a coordinate or point", ByBoth),
        bad(noise(r#"{"on": "body", "velocity": 1}"#), "noise[0]", "a motion is noise \"of\" a support", ByBoth),
        bad(noise(r#"{"on": "body", "of": "road", "velocity": 1}"#), "noise[0]", "and no \"on\"", ByBoth),
        bad(noise(r#"{"on": "road", "force": 1}"#), "noise[0].on", "name a coordinate or point", ByReader),
        bad(noise(r#"{"of": "raod", "velocity": 1}"#), "noise[0].of", "did you mean \"road\"?", ByReader),
        bad(noise(r#"{"of": "road", "velocity": -1}"#), "noise[0].velocity", "a density must be 0 or more", ByBoth),
        bad(noise(r#"{"of": "road", "velocity": 1, "band": [10, 1]}"#), "noise[0].band", "leave out \"band\" for white noise", ByReader),
        bad(road(r#""frictions": [{"between": ["road", "body"], "force": -1}]"#), "frictions[0].force", "must be a finite number, 0 or more", ByBoth),
        bad(road(r#""frictions": [{"between": ["road", "body"], "force": 2, "static": 1}]"#), "frictions[0].static", "not below the force while sliding", ByReader),
        bad(road(r#""frictions": [{"between": ["road", "lamp"], "force": 2}]"#), "frictions[0].between[1]", "is not the name of", ByReader),
        bad(road(r#""stops": [{"between": ["road", "ground"], "gap": 0, "stiffness": 1}]"#), "stops[0]", "an element between them does nothing", ByReader),
        bad(road(r#""impacts": [{"between": ["road", "body"], "gap": 0, "restitution": 1.5}]"#), "impacts[0].restitution", "a number from 0 to 1", ByBoth),
        bad(road(r#""controlled_dampers": [{"between": ["road", "body"], "law": "on-off skyhook", "low": 2, "high": 1}]"#), "controlled_dampers[0].high", "not below the low one", ByReader),
        bad(road(r#""controlled_dampers": [{"between": ["road", "body"], "law": "clipped skyhook", "low": 0, "high": 1}]"#), "controlled_dampers[0]", "give it", ByBoth),
        bad(road(r#""controlled_dampers": [{"between": ["road", "body"], "law": "on-off skyhook", "low": 0, "high": 1, "sky": 1}]"#), "controlled_dampers[0]", "leave it out", ByBoth),
        bad(noise(r#"{"of": "road", "velocity": 1, "band": [-1, 10]}"#), "noise[0].band", "the first 0 or more", ByBoth),
        bad(noise(r#"{"of": "road", "velocity": 1, "band": [1, 2, 3]}"#), "noise[0].band", "a band is two frequencies in Hz", ByBoth),
        // Elements and damping
        bad(one_spring(r#"{"between": ["left", "right"], "stiffness": 1, "name": ""}"#), "springs[0].name", "must not be empty", ByBoth),
        bad(road(r#""dampers": [{"between": ["body", "wheel"], "damping": 1, "name": "tyre"}]"#), "3:66: dampers[0].name", "must differ", ByReader),
        bad(one_spring(r#"{"between": ["left", "right"], "stiffness": 1, "loss_factor": -0.1}"#), "springs[0].loss_factor", "must be 0 or more", ByBoth),
        bad(road(r#""dampers": [{"between": ["body", "wheel"], "damping": 1, "loss_factor": 1}]"#), "dampers[0].loss_factor", "is unknown", ByBoth),
        bad(lossy(0.1), "springs[0].loss_factor", "structural damping is defined for harmonic motion alone", ByReader),
        bad(beam(r#""length": 0"#), "beams[0].length", "length", ByBoth),
        bad(beam(r#""flexural_rigidity": -1"#), "beams[0].flexural_rigidity", "rigidity", ByBoth),
        bad(beam(r#""mass_per_length": -1"#), "beams[0].mass_per_length", "mass per length", ByBoth),
        bad(beam(r#""elements": 0"#), "beams[0].elements", "expected a whole number from 1 to 10000000, found the number 0", ByBoth),
        bad(beam(r#""elements": 2.5"#), "beams[0].elements", "found the number 2.5", ByBoth),
        bad(beam(r#""ends": ["clamped", "fixed"]"#), "beams[0].ends[1]", "expected \"clamped\", \"pinned\", \"guided\" or \"free\"", ByBoth),
        bad(beam(r#""mass": "heavy""#), "beams[0].mass", "expected \"consistent\" or \"lumped\"", ByBoth),
        bad(r#"{"beams": []}"#, "1:1", "give at least one mass", ByBoth),
        bad(damped(r#""modal": 0.02"#, true), "damping.modal", "modal damping needs real undamped modes", ByReader),
        bad(damped(r#""modal": []"#, false), "damping.modal", "give at least one", ByBoth),
        bad(damped(r#""modal": [0.1, 0.2, 0.3]"#, false), "damping.modal", "3 ratios, more than there are modes (2)", ByReader),
        bad(damped(r#""modal": {"ratios": []}"#, false), "damping.modal.ratios", "give at least one", ByBoth),
        bad(damped(r#""rayleigh": {"mass": 1, "relative_to": "soul"}"#, false), "damping.rayleigh.relative_to", "did you mean \"soil\"?", ByReader),
        bad(damped(r#""modal": {"ratios": 0.1, "relative_to": "a"}"#, false), "damping.modal.relative_to", "is not the name of a support: known is \"soil\"", ByReader),
        bad(motions(r#"{"of": "road", "displacement": {"half_sine": {"height": 1, "duration": 0}}}"#), "motions[0].displacement.half_sine.duration", "its duration is 0.0", ByBoth),
        bad(loads(r#"{"on": "m1", "versine": {"force": 1, "duration": 1, "start": -1}}"#), "loads[0].versine.start", "must not start before 0", ByBoth),
        bad(loads(r#"{"on": "m1", "polynomial": {"coefficients": []}}"#), "loads[0].polynomial.coefficients", "it has 0 coefficients: give 1 to 7", ByBoth),
        bad(loads(r#"{"on": "m1", "polynomial": {"coefficients": [1, 1e306]}}"#), "loads[0].polynomial.coefficients[1]", "must be a finite number below 1e305", ByBoth),
        bad(motions(r#"{"of": "road", "velocity": {"polynomial": {"coefficients": [1, 2], "start": -1}}}"#), "motions[0].velocity.polynomial.start", "must not start before 0", ByBoth),
        bad(motions(r#"{"of": "road", "displacement": {"samples": {"step": 0.3, "values": [1], "hold": "zero"}}}"#), "motions[0].displacement.samples.step", "times or divided by a whole number", ByReader),
        bad(road(r#""points": [{"name": "p", "moves": {"body": 0.5, "road": 0.5}, "mass": 1}], "motions": [{"of": "road", "displacement": {"step": {"height": 1}}}]"#), "motions[0].displacement.step", "\"road\" carries mass", ByReader),
        bad(road(r#""points": [{"name": "p", "moves": {"body": 1}}], "loads": [{"on": "p", "step": {"force": 1}}, {"on": "body", "impulse": {"magnitude": 1, "at": -1}}]"#), "loads[1].impulse.at", "must not come before 0", ByBoth),
        bad(two_masses(r#""damping": {"modal": "0.02"}"#), "damping.modal", "expected a number, a list of numbers, or an object with \"ratios\"", ByBoth),
        bad(two_masses(r#""damping": {"modal": {"ratio": 0.02}}"#), "damping.modal.ratio", "did you mean \"ratios\"?", ByBoth),
        bad(two_masses(r#""damping": {"raleigh": {"mass": 1}}"#), "damping.raleigh", "did you mean \"rayleigh\"?", ByBoth),
        bad(two_masses(r#""damping": {"rayleigh": {"mas": 1}}"#), "damping.rayleigh.mas", "did you mean \"mass\"?", ByBoth),
    ]
}

/// A scene that asks for a motion of springs with a loss factor.
fn lossy(factor: f64) -> String {
    one_spring(&format!(
        r#"{{"between": ["left", "right"], "stiffness": 1, "loss_factor": {factor}}} ], "time": {{"end": 1, "step": 1}}, "dampers": ["#
    ))
}

#[test]
fn every_wrong_scene_is_refused_with_its_place() {
    let mut wrong = String::new();
    for bad in bad_scenes() {
        let shown: String = bad.text.chars().take(500).collect();
        let message = parse(&bad.text).expect_err(&shown).to_string();
        let begins = message.starts_with(&format!("{FILE}:"));
        let one_line = !message.contains('\n') && message.len() < 600;
        if !(begins && one_line && message.contains(bad.place) && message.contains(bad.says)) {
            let (place, says) = (bad.place, bad.says);
            wrong += &format!("{message}\n    should be at {place} and say {says}\n");
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// To be read: `cargo test --test scene -- --nocapture listing`.
#[test]
fn listing_of_all_messages() {
    for Bad { text, .. } in bad_scenes() {
        if let Err(error) = parse(&text) {
            println!("{error}");
        }
    }
}

fn temporary(name: &str, bytes: &[u8]) -> PathBuf {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&file, bytes).expect("the folder for tests can be written");
    file
}

#[test]
fn files_that_are_no_scene_are_refused_before_they_are_parsed() {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR"));
    let missing = folder.join("missing.json");
    assert!(matches!(Scene::read(&missing), Err(SceneError::Read { file, .. }) if file == missing));
    assert!(matches!(
        Scene::read(&folder),
        Err(SceneError::Directory { .. })
    ));
    let empty = temporary("empty.json", b"");
    assert!(matches!(Scene::read(&empty), Err(SceneError::Empty { .. })));

    let latin = temporary("latin.json", b"{\n \"title\": \"\xc3\xbc\xe4\" }");
    match Scene::read(&latin) {
        Err(SceneError::NotUtf8 { at }) => assert_eq!((at.line, at.column), (2, 13)),
        other => panic!("{other:?}"),
    }

    let large = folder.join("large.json");
    let file = std::fs::File::create(&large).expect("the folder for tests can be written");
    file.set_len(200 << 20).expect("a sparse file");
    let result = Scene::read(&large);
    std::fs::remove_file(&large).expect("it was just written");
    assert!(matches!(result, Err(SceneError::TooLarge { .. })));
}

#[test]
fn a_file_may_begin_with_a_byte_order_mark_and_end_lines_with_two_characters() {
    let text = two_masses("").replace('\n', "\r\n");
    assert!(parse(&format!("\u{feff}{text}")).is_ok());
    let message = parse("\u{feff}{\r\n\"masses\": 1 }")
        .expect_err("no list")
        .to_string();
    assert!(message.starts_with("scene.json:2:11: masses:"), "{message}");
}

#[test]
fn columns_count_characters() {
    let message = parse("{ \"title\": \"äöü\", \"mases\": 1 }").expect_err("a misspelled key");
    assert!(
        message.to_string().starts_with("scene.json:1:25: mases:"),
        "{message}"
    );
}

#[test]
fn a_scene_without_time_asks_for_no_response() {
    let scene = parse(&two_masses(r#""title": "Two""#)).expect("a scene");
    assert_eq!(scene.title(), Some("Two"));
    assert!(scene.problem().is_none());
    // Any sample step will do as long as there is no grid.
    let samples =
        r#""loads": [{"on": "m1", "samples": {"step": 0.15, "values": [1], "hold": "zero"}}]"#;
    assert!(parse(&two_masses(samples)).is_ok());
}

#[test]
fn everything_given_arrives() {
    let scene = parse(&two_masses(
        r#""dampers": [{"between": ["m2", "ground"], "damping": -3}],
           "initial": {"m2": {"velocity": 4}, "m1": {"displacement": 5}},
           "loads": [{"on": "m2", "step": {"force": 6}},
                     {"on": "m2", "ramp": {"rate": 7, "start": -8}},
                     {"on": "m1", "impulse": {"magnitude": 9, "at": 10}},
                     {"on": "m1", "harmonic": {"amplitude": 11, "frequency": 12}},
                     {"on": "m1", "samples": {"step": 0.5, "values": [13, 14], "hold": "first"}}],
           "time": {"end": 15, "step": 0.25}"#,
    ))
    .expect("a scene");
    use eigentone::response::{Harmonic, Hold, Impulse, Ramp, Samples, Step};
    let system = scene.system();
    assert_eq!(system.names(), ["m1", "m2"]);
    assert_eq!(system.masses(), [2.0, 1.0]);
    let damping = system.damping_matrix();
    assert_eq!((damping[(0, 0)], damping[(1, 1)]), (0.0, -3.0));
    let problem = scene
        .problem()
        .expect("it has a time")
        .expect("it was checked");
    assert_eq!(problem.initial_displacement(), [5.0, 0.0]);
    assert_eq!(problem.initial_velocity(), [0.0, 4.0]);
    assert_eq!((problem.grid().step(), problem.grid().last()), (0.25, 60));
    let samples = Samples {
        step: 0.5,
        values: vec![13.0, 14.0],
        hold: Hold::First,
    };
    let expected: [(usize, Load); 5] = [
        (1, Step::of(6.0).into()),
        (1, Ramp::of(7.0).starting_at(-8.0).into()),
        (0, Impulse::of(9.0).at(10.0).into()),
        (0, Harmonic::of(11.0, 12.0).into()),
        (0, samples.into()),
    ];
    let loads = problem
        .loads()
        .iter()
        .map(|applied| (applied.coordinate, applied.load.clone()));
    assert_eq!(loads.collect::<Vec<_>>(), expected);
}

#[test]
fn matrices_add_to_elements_and_name_coordinates() {
    let scene = parse(
        r#"{ "matrices": {"stiffness": [[4, -1], [1, 4]], "mass": [[1, 0], [0, 2]]},
             "springs": [{"between": ["x2", "ground"], "stiffness": 8}],
             "initial": {"x1": {"velocity": 1}},
             "time": {"end": 1, "step": 1} }"#,
    )
    .expect("a scene");
    assert_eq!(scene.system().names(), ["x1", "x2"]);
    let stiffness = scene.system().stiffness_matrix();
    let entries = [(0, 0), (0, 1), (1, 0), (1, 1)].map(|at| stiffness[at]);
    assert_eq!(entries, [4.0, -1.0, 1.0, 12.0]);
    assert_eq!(scene.system().mass_matrix()[(1, 1)], 2.0);
}

/// The double that the reader makes of a number's text.
fn read_number(number: &str) -> f64 {
    let spring = format!(r#"{{"between": ["left", "right"], "stiffness": {number}}}"#);
    let scene = parse(&one_spring(&spring)).unwrap_or_else(|error| panic!("{error}"));
    scene.system().springs()[0].coefficient
}

#[test]
fn numbers_are_the_nearest_doubles() {
    for number in [
        "0",
        "-0",
        "-0.0",
        "1e3",
        "1E+3",
        "0.1e1",
        "12345678901234567890",
        "18446744073709551615",
        "18446744073709551616",
        "-9223372036854775809",
        "9007199254740993",
        "9007199254740992.9999999999999999999999",
        "2.2250738585072011e-308",
        "2.4703282292062327e-324",
        "2.4703282292062328e-324",
        "1e-400",
        "5e-324",
        "1.7976931348623158e308",
        "123456789012345678901234567890",
        "0.1000000000000000055511151231257827021181583404541015625",
    ] {
        let expected: f64 = number.parse().expect("a number");
        assert_eq!(
            read_number(number).to_bits(),
            expected.to_bits(),
            "{number}"
        );
    }
}

/// Every command that reads a scene, with what it writes sent to `out`.
fn commands(scene: &Path, out: &Path) -> [Vec<PathBuf>; 3] {
    let (scene, out) = (scene.to_owned(), out.to_owned());
    [
        vec!["modes".into(), scene.clone(), "--json".into()],
        vec!["response".into(), scene.clone(), "--json".into()],
        vec!["analyze".into(), scene, "--out".into(), out],
    ]
}

/// The command refuses a file with the reader's message, status 2 and nothing else.
fn assert_refused(scene: &Path, message: &str) {
    let out = scene.with_extension("out");
    for arguments in commands(scene, &out) {
        let output = Command::new(env!("CARGO_BIN_EXE_eigentone"))
            .args(&arguments)
            .output()
            .expect("the command was built");
        let said = String::from_utf8(output.stderr).expect("messages are text");
        assert_eq!(output.status.code(), Some(2), "{arguments:?} says {said}");
        assert!(output.stdout.is_empty(), "{arguments:?}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(said.contains(message), "{message} is not in {said}");
        assert!(!out.exists(), "{arguments:?} wrote something");
    }
}

#[test]
fn the_command_refuses_wrong_scenes() {
    for (i, Bad { text, .. }) in bad_scenes().into_iter().enumerate() {
        let scene = temporary(&format!("bad-{i}.json"), text.as_bytes());
        let message = Scene::read(&scene).expect_err("it is wrong").to_string();
        assert_refused(&scene, &message);
    }
    let missing = Path::new(env!("CARGO_TARGET_TMPDIR")).join("missing.json");
    assert_refused(&missing, "missing.json: cannot be read");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    assert_refused(folder, "is a directory");
    let latin = temporary("latin-command.json", b"{ \"title\": \"\xe4\" }");
    assert_refused(&latin, "latin-command.json:1:13: is not UTF-8");
}

/// The schema of the docs, ready to validate.
struct Schema {
    schemas: Schemas,
    index: SchemaIndex,
}

impl Schema {
    fn load() -> Schema {
        let text = include_str!("../docs/scene.schema.json");
        let schema = serde_json::from_str(text).expect("the schema is JSON");
        let mut schemas = Schemas::new();
        let mut compiler = Compiler::new();
        compiler
            .add_resource("scene.schema.json", schema)
            .expect("a name without a fragment");
        let index = compiler.compile("scene.schema.json", &mut schemas);
        let index = index.unwrap_or_else(|error| panic!("the schema is no schema: {error:#}"));
        Schema { schemas, index }
    }

    fn accepts(&self, scene: &Value) -> bool {
        self.schemas.validate(scene, self.index).is_ok()
    }
}

#[test]
fn the_schema_refuses_what_it_can_see() {
    let schema = Schema::load();
    for Bad { text, seen, .. } in bad_scenes() {
        match (seen, serde_json::from_str::<Value>(&text)) {
            (AsText, value) => assert!(value.is_err(), "{text}"),
            (ByBoth, value) => assert!(!schema.accepts(&value.expect(&text)), "{text}"),
            (ByReader, value) => assert!(schema.accepts(&value.expect(&text)), "{text}"),
        }
    }
}

/// Every `json` block of the docs.
fn documented() -> Vec<&'static str> {
    let text = include_str!("../docs/scene.md");
    let blocks = text.split("```json\n").skip(1);
    blocks
        .map(|rest| rest.split("```").next().expect("split has a first part"))
        .collect()
}

#[test]
fn documented_scenes_are_scenes() {
    let schema = Schema::load();
    let scenes = documented();
    assert!(scenes.len() >= 8);
    for text in scenes {
        let scene = parse(text).unwrap_or_else(|error| panic!("{error} in {text}"));
        let value: Value = serde_json::from_str(text).expect("it was just read");
        assert!(schema.accepts(&value), "{text}");
        assert_eq!(scene.problem().is_some(), value.get("time").is_some());
    }
}

/// A scene in which every key of the format occurs but those of matrices.
fn everything() -> Value {
    json!({
        "$schema": "scene.schema.json",
        "title": "Everything",
        "masses": [{"name": "a", "mass": 1}, {"name": "b", "mass": 2, "unit": "m"}, {"name": "c", "mass": 2, "unit": "rad"}],
        "points": [{"name": "p", "moves": {"a": 1, "c": -0.5}, "mass": 1}, {"name": "q", "moves": {"road": 2, "c": 1}}],
        "supports": ["road"],
        "beams": [{"name": "mast", "length": 2, "elements": 1, "flexural_rigidity": 1, "mass_per_length": 1,
                   "ends": ["clamped", "free"], "mass": "consistent"},
                  {"name": "bar", "length": 2, "elements": 2, "flexural_rigidity": 1, "mass_per_length": 1,
                   "ends": ["pinned", "guided"], "mass": "lumped"}],
        "rods": [{"name": "rod", "length": 2, "elements": 1, "axial_rigidity": 1, "mass_per_length": 1,
                  "ends": ["fixed", "free"], "mass": "lumped"}],
        "springs": [{"between": ["ground", "a"], "stiffness": 1, "name": "left", "loss_factor": 0},
                    {"between": ["q", "p"], "stiffness": 1}, {"between": ["ground", "b"], "stiffness": 1},
                    {"between": ["road", "c"], "stiffness": 1}],
        "dampers": [{"between": ["a", "b"], "damping": 1, "name": "right"}],
        "damping": {"rayleigh": {"mass": 0.5, "stiffness": 0.5, "relative_to": "road"},
                    "modal": {"ratios": [0.5, 0.25], "relative_to": "road"}},
        "initial": {"a": {"displacement": 1, "velocity": 1}},
        "loads": [
            {"on": "a", "step": {"force": 1, "start": 0}},
            {"on": "p", "ramp": {"rate": 1, "start": 0}},
            {"on": "a", "impulse": {"magnitude": 1, "at": 0}},
            {"on": "a", "harmonic": {"amplitude": 1, "frequency": 1, "phase": 0}},
            {"on": "a", "half_sine": {"force": 1, "duration": 1, "start": 0}},
            {"on": "a", "versine": {"force": 1, "duration": 1, "start": 0}},
            {"on": "a", "polynomial": {"coefficients": [1, 1], "start": 0}},
            {"on": "a", "samples": {"step": 1, "values": [1], "hold": "zero"}},
        ],
        "motions": [
            {"of": "road", "displacement": {"step": {"height": 1, "start": 0}}},
            {"of": "road", "velocity": {"ramp": {"rate": 1, "start": 0}}},
            {"of": "road", "acceleration": {"harmonic": {"amplitude": 1, "frequency": 1, "phase": 0}}},
            {"of": "road", "displacement": {"half_sine": {"height": 1, "duration": 1, "start": 0}}},
            {"of": "road", "displacement": {"versine": {"height": 1, "duration": 1, "start": 0}}},
            {"of": "road", "acceleration": {"polynomial": {"coefficients": [1, 1], "start": 0}}},
            {"of": "road", "displacement": {"samples": {"step": 1, "hold": "zero",
                "values": {"file": "tests/scene/record.csv", "column": 2}}}},
        ],
        "outputs": [
            {"name": "sum", "displacement": {"a": 1, "road": -1}, "velocity": {"p": 1}, "acceleration": {"b": 1}},
            {"name": "pull", "force": "right"},
        ],
        "frictions": [{"between": ["a", "b"], "force": 1, "static": 2}],
        "stops": [{"between": ["ground", "a"], "gap": 1, "stiffness": 1, "damping": 1}],
        "impacts": [{"between": ["a", "p"], "gap": 1, "restitution": 0.5}],
        "controlled_dampers": [{"between": ["a", "b"], "law": "clipped skyhook", "low": 1, "high": 2, "sky": 1},
                               {"between": ["a", "b"], "law": "on-off skyhook", "low": 1, "high": 2}],
        "noise": [{"on": "p", "force": 1}, {"of": "road", "displacement": 1}, {"of": "road", "velocity": 1},
                  {"of": "road", "acceleration": 1, "band": [0, 10]}],
        "time": {"end": 10, "step": 1},
        "frequencies": {"from": 1, "to": 10, "count": 5, "spacing": "log"}
    })
}

/// The JSON pointers of all values inside a value.
fn pointers(value: &Value, at: &str, found: &mut Vec<String>) {
    let mut inside = |key: &str, value: &Value| {
        let pointer = format!("{at}/{key}");
        pointers(value, &pointer, found);
        found.push(pointer);
    };
    match value {
        Value::Array(list) => {
            list.iter()
                .enumerate()
                .for_each(|(i, value)| inside(&i.to_string(), value));
        }
        Value::Object(members) => members.iter().for_each(|(key, value)| inside(key, value)),
        _ => {}
    }
}

/// The keys of all objects that a schema describes.
fn schema_keys(schema: &Value, keys: &mut Vec<String>) {
    if let Some(Value::Object(properties)) = schema.get("properties") {
        keys.extend(properties.keys().cloned());
    }
    match schema {
        Value::Array(list) => list.iter().for_each(|value| schema_keys(value, keys)),
        Value::Object(members) => members.values().for_each(|value| schema_keys(value, keys)),
        _ => {}
    }
}

/// The rest of them.
fn matrices() -> Value {
    json!({
        "masses": [{"name": "a", "mass": 1}, {"name": "b", "mass": 2}],
        "matrices": {"mass": [[1, 0], [0, 1]], "damping": [[0, 0], [0, 0]], "stiffness": [[1, 0], [0, 1]]},
        "damping": {"modal": [0.1]},
    })
}

/// Schema and reader agree about every key: with one left out, or with another value in its place.
#[test]
fn schema_and_reader_agree() {
    let schema = Schema::load();
    let scenes = [everything(), matrices()];
    let mut all = Vec::new();
    for whole in &scenes {
        assert!(schema.accepts(whole));
        parse(&whole.to_string()).unwrap_or_else(|error| panic!("{error}"));
        pointers(whole, "", &mut all);
    }
    let mut keys = Vec::new();
    schema_keys(
        &serde_json::from_str(include_str!("../docs/scene.schema.json")).expect("JSON"),
        &mut keys,
    );
    for key in keys {
        assert!(
            all.iter().any(|at| at.ends_with(&format!("/{key}"))),
            "{key} is not tried"
        );
    }

    let agree = |changed: &Value, how: &str| {
        let read = parse(&changed.to_string());
        match read {
            Ok(_) => assert!(schema.accepts(changed), "the schema alone refuses {how}"),
            Err(SceneError::Shape { .. } | SceneError::Choice { .. }) => {
                assert!(!schema.accepts(changed), "the reader alone refuses {how}");
            }
            Err(_) => {}
        }
    };
    let others = [
        json!(null),
        json!(true),
        json!(-1),
        json!(0),
        json!(0.5),
        json!("a"),
        json!([]),
        json!([1]),
        json!({}),
        json!({"a": 1}),
    ];
    for (whole, at) in scenes
        .iter()
        .flat_map(|whole| all.iter().map(move |at| (whole, at)))
    {
        for other in &others {
            let mut changed = whole.clone();
            let Some(place) = changed.pointer_mut(at) else {
                continue;
            };
            *place = other.clone();
            agree(&changed, &format!("{other} at {at}"));
        }
        let (parent, key) = at.rsplit_once('/').expect("pointers begin with a slash");
        let mut changed = whole.clone();
        if let Some(Value::Object(members)) = changed.pointer_mut(parent) {
            members.remove(key);
            agree(&changed, &format!("the lack of {at}"));
        }
    }
}

proptest! {
    #[test]
    fn any_decimal_is_read_as_its_nearest_double(
        digits in "-?(0|[1-9][0-9]{0,30})(\\.[0-9]{1,30})?",
        exponent in -330i32..277,
    ) {
        let number = format!("{digits}e{exponent}");
        let expected: f64 = number.parse().expect("a number");
        prop_assert_eq!(read_number(&number).to_bits(), expected.to_bits());
    }

    #[test]
    fn any_double_is_read_back(bits: u64) {
        let number = f64::from_bits(bits);
        prop_assume!(number.is_finite());
        prop_assert_eq!(read_number(&format!("{number:e}")).to_bits(), bits);
        prop_assert_eq!(read_number(&serde_json::to_string(&number).expect("finite")).to_bits(), bits);
    }
}

/// What may stand where a number or a name was.
const INTRUDERS: [&str; 16] = [
    "0",
    "-1",
    "1e999",
    "5e-324",
    "1.7e308",
    "-0.0",
    "null",
    "true",
    "\"m1\"",
    "\"ground\"",
    "\"\"",
    "[]",
    "{}",
    "[[1]]",
    "\u{feff}",
    "\\",
];

/// Changes to a text: where (as a part of its length), how many bytes, and what becomes of them.
fn mutated(text: &str, changes: &[(f64, usize, usize)]) -> String {
    let mut bytes = text.as_bytes().to_vec();
    for &(place, length, what) in changes {
        let start = (place * bytes.len() as f64) as usize;
        let end = (start + length).min(bytes.len());
        let cut = bytes[start..end].to_vec();
        match what {
            0 => drop(bytes.drain(start..end)),
            1 => drop(bytes.splice(end..end, cut)),
            _ => {
                // A whole token, so that the text often stays JSON.
                let ends = |byte: &u8| b",:[]{} \n".contains(byte);
                let rest = bytes[start..].iter().position(ends).unwrap_or(0);
                let intruder = INTRUDERS[what % INTRUDERS.len()].bytes();
                drop(bytes.splice(start..start + rest, intruder));
            }
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn no_change_to_a_scene_makes_the_reader_panic(
        case in 0..cases().len(),
        changes in proptest::collection::vec((0.0..1.0, 1usize..40, 0usize..20), 1..4),
    ) {
        let text = mutated(cases()[case].scene_text(), &changes);
        match parse(&text) {
            Ok(scene) => prop_assert!(scene.problem().is_none_or(|problem| problem.is_ok())),
            Err(error) => {
                let message = error.to_string();
                prop_assert!(message.starts_with("scene.json:") && message.len() < 1000);
                prop_assert!(!message.contains('\n'), "{}", message);
            }
        }
    }
}
