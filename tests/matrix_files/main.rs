//! Matrices as files: what is read, and what is refused, by lines of Matrix Market files and bytes of PETSc's.

mod petsc;

use std::fs;
use std::path::{Path, PathBuf};

use eigentone::modes::{MatrixKind, System};
use eigentone::scene::Scene;
use faer::{Mat, mat};

/// A directory of this test's own.
fn directory(name: &str) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("matrix-files")
        .join(name);
    fs::create_dir_all(&directory).expect("a directory");
    directory
}

/// The scene whose stiffness matrix is this file, with unit masses as rows of numbers.
fn read(name: &str, file: &[u8]) -> Result<System, String> {
    let directory = directory(name);
    fs::write(directory.join("k.mtx"), file).expect("written");
    let scene =
        r#"{"matrices": {"mass": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "stiffness": "k.mtx"}}"#;
    let path = directory.join("scene.json");
    fs::write(&path, scene).expect("written");
    Scene::read(&path)
        .map(|scene| scene.system().clone())
        .map_err(|error| error.to_string())
}

#[test]
fn every_layout_gives_the_same_matrix() {
    let symmetric = mat![[4.0, -1.5, 0.0], [-1.5, 3.0, -1.0], [0.0, -1.0, 2.0]];
    let skew = mat![[0.0, -2.0, 0.0], [2.0, 0.0, 7.0], [0.0, -7.0, 0.0]];
    let cases: [(&str, &str, &Mat<f64>); 9] = [
        (
            "windows-with-comments",
            "%%MatrixMarket matrix coordinate real general\r\n% a comment\r\n%\r\n\r\n3 3 7\r\n1 1 4\r\n2 1 -1.5\r\n1 2 -1.5\r\n2 2 3\r\n3 2 -1\r\n2 3 -1\r\n3 3 2",
            &symmetric,
        ),
        (
            "coordinate-general",
            "%%MatrixMarket matrix coordinate real general\n% a comment\n\n3 3 7\n1 1 4\n2 1 -1.5\n1 2 -15e-1\n2 2 3.\n3 2 -1\n2 3 -1\n3 3 +2\n",
            &symmetric,
        ),
        (
            "coordinate-symmetric",
            "%%MatrixMarket matrix coordinate real symmetric\r\n3 3 5\r\n3 3 2\r\n1 1 4\r\n2 1 -1.5\r\n2 2 3\r\n3 2 -1\r\n",
            &symmetric,
        ),
        (
            "a-stored-zero",
            "%%MatrixMarket matrix coordinate real symmetric\n3 3 6\n1 1 4\n2 1 -1.5\n2 2 3\n3 1 0\n3 2 -1\n3 3 2",
            &symmetric,
        ),
        (
            "array-general",
            "%%MatrixMarket matrix array real general\n3 3\n4\n-1.5\n0\n-1.5\n3\n-1\n0\n-1\n2\n",
            &symmetric,
        ),
        (
            "array-symmetric",
            "%%matrixmarket MATRIX Array Real Symmetric\n%%%\n3 3\n4\n-1.5\n0\n3\n-1\n2\n\n",
            &symmetric,
        ),
        (
            "coordinate-skew",
            "%%MatrixMarket matrix coordinate integer skew-symmetric\n3 3 2\n2 1 2\n3 2 -7\n",
            &skew,
        ),
        (
            "array-skew",
            "%%MatrixMarket matrix array integer skew-symmetric\n3 3\n2\n0\n-7\n",
            &skew,
        ),
        (
            "empty",
            "%%MatrixMarket matrix coordinate real symmetric\n3 3 0\n",
            &Mat::zeros(3, 3),
        ),
    ];
    for (name, file, expected) in cases {
        let system = read(name, file.as_bytes()).unwrap_or_else(|error| panic!("{name}: {error}"));
        let added = system.added(MatrixKind::Stiffness).expect("it was given");
        assert_eq!(added, expected.as_ref(), "{name}");
    }
}

#[test]
fn numbers_are_those_of_scenes() {
    // The double nearest to the text, whatever its digits.
    let text = "0.1000000000000000055511151231257827021181583404541015626";
    let file = format!("%%MatrixMarket matrix coordinate real general\n3 3 1\n2 3 {text}\n");
    let system = read("digits", file.as_bytes()).unwrap();
    assert_eq!(system.added(MatrixKind::Stiffness).unwrap()[(1, 2)], 0.1);
}

#[test]
fn a_matrix_given_by_a_file_that_is_not_there() {
    let path = directory("missing").join("scene.json");
    let text = r#"{"matrices": {"mass": "nowhere/m.mtx"}}"#;
    let error = Scene::parse(text, &path).unwrap_err().to_string();
    assert!(
        error.contains("scene.json:1:23: matrices.mass: "),
        "{error}"
    );
    assert!(error.contains("nowhere/m.mtx: cannot be read"), "{error}");
    let error = Scene::parse(r#"{"matrices": {"mass": "."}}"#, &path)
        .unwrap_err()
        .to_string();
    assert!(error.contains("is not a file"), "{error}");
}

#[test]
fn what_is_wrong_is_named_with_its_line() {
    const HEAD: &str = "%%MatrixMarket matrix coordinate real symmetric\n";
    const GENERAL: &str = "%%MatrixMarket matrix coordinate real general\n";
    const ARRAY: &str = "%%MatrixMarket matrix array real general\n";
    let head = |rest: &str| format!("{HEAD}{rest}");
    let cases: Vec<(&str, String, usize, &str)> = vec![
        ("nothing", String::new(), 1, "is not the head"),
        ("no-head", "3 3 1\n1 1 1\n".into(), 1, "is not the head"),
        (
            "one-percent",
            "%MatrixMarket matrix coordinate real general\n".into(),
            1,
            "is not the head",
        ),
        (
            "short-head",
            "%%MatrixMarket matrix coordinate real\n".into(),
            1,
            "4 words instead of 5",
        ),
        (
            "long-head",
            "%%MatrixMarket matrix coordinate real general x\n".into(),
            1,
            "6 words instead of 5",
        ),
        (
            "vector",
            "%%MatrixMarket vector coordinate real general\n".into(),
            1,
            "expected \"matrix\"",
        ),
        (
            "layout",
            "%%MatrixMarket matrix dense real general\n".into(),
            1,
            "expected \"coordinate\" or \"array\"",
        ),
        (
            "complex",
            "%%MatrixMarket matrix coordinate complex general\n".into(),
            1,
            "expected \"real\" or \"integer\"",
        ),
        (
            "pattern",
            "%%MatrixMarket matrix coordinate pattern general\n".into(),
            1,
            "a pattern has no values",
        ),
        (
            "hermitian",
            "%%MatrixMarket matrix coordinate real hermitian\n".into(),
            1,
            "expected \"general\", \"symmetric\"",
        ),
        (
            "no-size",
            head("% only comments\n"),
            3,
            "ends before its size",
        ),
        (
            "two-sizes",
            head("3 3\n"),
            2,
            "rows, columns and entries, 3 whole numbers",
        ),
        ("words", head("3 three 1\n"), 2, "is not the size"),
        ("negative", head("-3 3 1\n"), 2, "is not the size"),
        (
            "array-size",
            format!("{ARRAY}3 3 9\n"),
            2,
            "rows and columns, 2 whole numbers",
        ),
        (
            "rectangle",
            head("3 4 1\n1 1 1\n"),
            2,
            "3 × 4: M, C and K must be square",
        ),
        ("zero", head("0 0 0\n"), 2, "0 × 0"),
        (
            "huge",
            head("99999999999 99999999999 1\n1 1 1\n"),
            2,
            "more than the 10000000",
        ),
        (
            "too-huge",
            head("99999999999999999999999 3 1\n1 1 1\n"),
            2,
            "is not the size",
        ),
        ("many", head("3 3 7\n"), 2, "7 entries are more than the 6"),
        (
            "announced",
            head("1000000 1000000 900000000\n1 1 1\n"),
            2,
            "do not fit into a file",
        ),
        (
            "array-huge",
            format!("{ARRAY}1000000 1000000\n1\n"),
            2,
            "do not fit into a file",
        ),
        (
            "ends",
            head("3 3 3\n1 1 1\n2 2 1\n"),
            5,
            "ends after 2 of 3 entries",
        ),
        (
            "more",
            head("3 3 1\n1 1 1\n2 2 1\n"),
            4,
            "more after the last of the entries announced, 1",
        ),
        ("row-0", head("3 3 1\n0 1 1\n"), 3, "from 1 to 3"),
        ("row-4", head("3 3 1\n4 1 1\n"), 3, "from 1 to 3"),
        ("row-half", head("3 3 1\n1.5 1 1\n"), 3, "from 1 to 3"),
        ("column-0", head("3 3 1\n1 0 1\n"), 3, "from 1 to 3"),
        ("column-4", head("3 3 1\n3 4 1\n"), 3, "from 1 to 3"),
        ("column-negative", head("3 3 1\n3 -1 1\n"), 3, "from 1 to 3"),
        ("entries-negative", head("3 3 -1\n"), 2, "is not the size"),
        (
            "entries-huge",
            head("3 3 99999999999999999999999\n"),
            2,
            "is not the size",
        ),
        (
            "array-ends",
            format!("{ARRAY}3 3\n1\n2\n"),
            5,
            "ends after 2 of 9 entries",
        ),
        (
            "array-more",
            format!("{ARRAY}3 3\n{}", "1\n".repeat(10)),
            12,
            "more after the last of the entries announced, 9",
        ),
        (
            "array-nan",
            format!("{ARRAY}3 3\n1\nnan\n1\n1\n1\n1\n1\n1\n1\n"),
            4,
            "\"nan\" is not a number",
        ),
        (
            "minus-infinity",
            head("3 3 1\n1 1 -inf\n"),
            3,
            "\"-inf\" is not a number",
        ),
        (
            "minus-beyond",
            head("3 3 1\n1 1 -1e999\n"),
            3,
            "is too large",
        ),
        (
            "skew-upper",
            "%%MatrixMarket matrix coordinate real skew-symmetric\n3 3 1\n1 2 1\n".into(),
            3,
            "lies above the diagonal",
        ),
        (
            "twice-by-its-mirror",
            head("3 3 2\n2 1 1\n1 2 1\n"),
            4,
            "lies above the diagonal",
        ),
        (
            "twice-in-windows",
            head("3 3 2\n2 1 1\n2 1 1\n").replace('\n', "\r\n"),
            4,
            "given before, in line 3",
        ),
        ("two-words", head("3 3 1\n1 1\n"), 3, "2 words"),
        ("four-words", head("3 3 1\n1 1 1 1\n"), 3, "4 words"),
        (
            "upper",
            head("3 3 1\n1 2 1\n"),
            3,
            "lies above the diagonal",
        ),
        (
            "twice",
            head("3 3 3\n1 1 1\n2 2 1\n1 1 2\n"),
            5,
            "given before, in line 3",
        ),
        (
            "word",
            head("3 3 1\n1 1 one\n"),
            3,
            "\"one\" is not a number",
        ),
        (
            "infinite",
            head("3 3 1\n1 1 inf\n"),
            3,
            "\"inf\" is not a number",
        ),
        (
            "nan",
            head("3 3 1\n1 1 NaN\n"),
            3,
            "\"NaN\" is not a number",
        ),
        (
            "fortran",
            head("3 3 1\n1 1 1d5\n"),
            3,
            "\"1d5\" is not a number",
        ),
        ("beyond", head("3 3 1\n1 1 1e999\n"), 3, "is too large"),
        (
            "fraction",
            "%%MatrixMarket matrix coordinate integer general\n3 3 1\n1 1 0.5\n".into(),
            3,
            "is not a whole number",
        ),
        (
            "skew-diagonal",
            "%%MatrixMarket matrix coordinate real skew-symmetric\n3 3 1\n2 2 1\n".into(),
            3,
            "lies on the diagonal",
        ),
        (
            "array-words",
            format!("{ARRAY}3 3\n1 2 3\n4 5 6\n7 8 9\n1\n1\n1\n1\n1\n1\n"),
            3,
            "3 words",
        ),
        (
            "late-comment",
            format!("{GENERAL}3 3 1\n% here\n1 1 1\n"),
            3,
            "2 words",
        ),
        (
            "long",
            format!("{GENERAL}3 3 1\n{}\n", "1".repeat(5000)),
            3,
            "longer than 4096 bytes",
        ),
    ];
    for (name, file, line, problem) in cases {
        let error = match read(name, file.as_bytes()) {
            Err(error) => error,
            Ok(_) => panic!("{name} was read"),
        };
        assert!(
            error.contains(&format!("k.mtx:{line}: ")),
            "{name}: {error}"
        );
        assert!(error.contains(problem), "{name}: {error}");
        assert!(error.contains("matrices.stiffness"), "{name}: {error}");
    }
    // Bytes that are no text.
    let error = read(
        "bytes",
        b"%%MatrixMarket matrix coordinate real general\n3 3 1\n1 1 \xff\n",
    );
    assert!(error.unwrap_err().contains("k.mtx:3: "));
}

#[test]
fn sizes_that_disagree() {
    let error = read(
        "sizes",
        b"%%MatrixMarket matrix coordinate real general\n2 2 1\n1 1 1\n",
    );
    let error = error.unwrap_err();
    assert!(error.contains("matrices.stiffness"), "{error}");
    assert!(error.contains("2 × 2: it must be 3 × 3"), "{error}");
}
