//! The functions behind the Python package `eigentone`: arrays in, arrays with bounds out.
#![deny(missing_docs)]

use std::ffi::CStr;
use std::path::Path;

use eigentone::modes::{Bounds, MatrixKind, Modes, Precision, System};
use eigentone::response::{BoundedMatrix, Hold, Quantity, ResponsePlan, Trajectory, expm_bounded};
use eigentone::scene::Scene;
use eigentone::switching::{Event, Switching};
use faer::{Mat, MatRef};
use num_complex::Complex;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2, ToPyArray, ndarray::Array2};
use pyo3::exceptions::{PyUserWarning, PyValueError};
use pyo3::prelude::*;

/// What is wrong with the input, or why there is no answer, as a `ValueError`.
fn wrong(error: impl std::fmt::Display) -> PyErr {
    PyValueError::new_err(error.to_string())
}

/// What the word for `of` stands for.
fn choice<T: Copy>(of: &str, given: &Bound<'_, PyAny>, words: &[(&str, T)]) -> PyResult<T> {
    let word: Option<String> = given.extract().ok();
    let mut known = words.iter();
    match known.find(|(known, _)| word.as_deref() == Some(known)) {
        Some((_, choice)) => Ok(*choice),
        None => {
            let words: Vec<String> = words.iter().map(|(word, _)| format!("{word:?}")).collect();
            let (given, words) = (given.repr()?, words.join(" or "));
            Err(wrong(format!("{of} is {given}: it must be {words}")))
        }
    }
}

fn precision(given: &Bound<'_, PyAny>) -> PyResult<Precision> {
    let (certified, double) = (Precision::default(), Precision::Double);
    choice(
        "precision",
        given,
        &[("certified", certified), ("double", double)],
    )
}

/// The word for how sure bounds are.
fn worth(bounds: Bounds) -> &'static str {
    match bounds {
        Bounds::Proven => "proven",
        Bounds::Estimated => "estimated",
    }
}

fn scene(text: &str, file: &str) -> PyResult<Scene> {
    Scene::parse(text, Path::new(file)).map_err(wrong)
}

/// What an answer leaves out of a scene, if anything.
fn left_out(scene: &Scene) -> Option<&'static CStr> {
    let note = c"modes, frequency responses and state-space forms are of the scene without its frictions, stops, impacts and controlled dampers";
    (!scene.switches().is_empty()).then_some(note)
}

/// Warns the caller of the function in Python of what is left out.
fn warn_of_left_out(py: Python<'_>, scene: &Scene) -> PyResult<()> {
    match left_out(scene) {
        None => Ok(()),
        Some(note) => PyErr::warn(py, &py.get_type::<PyUserWarning>(), note, 2),
    }
}

fn matrix(array: &PyReadonlyArray2<'_, f64>) -> Mat<f64> {
    let view = array.as_array();
    Mat::from_fn(view.nrows(), view.ncols(), |i, j| view[(i, j)])
}

fn array(matrix: MatRef<'_, f64>) -> Array2<f64> {
    Array2::from_shape_fn(matrix.shape(), |(i, j)| matrix[(i, j)])
}

/// Bounds as numbers; NaN where there is none.
fn numbers(bounds: &[Option<f64>]) -> Vec<f64> {
    let bounds = bounds.iter();
    bounds.map(|bound| bound.unwrap_or(f64::NAN)).collect()
}

/// A system of matrices alone; its coordinates are x1, x2, …, as in a scene.
fn system(
    mass: &PyReadonlyArray2<'_, f64>,
    damping: Option<&PyReadonlyArray2<'_, f64>>,
    stiffness: &PyReadonlyArray2<'_, f64>,
) -> PyResult<System> {
    let mut builder = System::builder().matrix(MatrixKind::Mass, matrix(mass).as_ref());
    if let Some(damping) = damping {
        builder = builder.matrix(MatrixKind::Damping, matrix(damping).as_ref());
    }
    let builder = builder.matrix(MatrixKind::Stiffness, matrix(stiffness).as_ref());
    builder.build().map_err(wrong)
}

type Vector<'py, T> = Bound<'py, PyArray1<T>>;
type Table<'py, T> = Bound<'py, PyArray2<T>>;

/// Names; roots with bounds of them and of their real parts; how many are infinite; of each mode its place among the
/// roots' values, its damping ratio, its time constant and its shape; how sure the bounds are, and whether no root is missing.
type ModesAnswer<'py> = (Roots<'py>, OfModes<'py>, &'static str, bool);
type Roots<'py> = (
    Vec<String>,
    Vector<'py, Complex<f64>>,
    Vector<'py, f64>,
    Vector<'py, f64>,
    usize,
);
type OfModes<'py> = (
    Vector<'py, Complex<f64>>,
    Vector<'py, f64>,
    Vector<'py, f64>,
    Vector<'py, f64>,
    Vec<String>,
    Table<'py, Complex<f64>>,
    Table<'py, f64>,
);

fn answer<'py>(py: Python<'py>, system: &System, modes: &Modes) -> ModesAnswer<'py> {
    let n = system.len();
    let roots = modes.eigenvalues();
    let values: Vec<Complex<f64>> = roots.iter().map(|root| root.value).collect();
    let bounds: Vec<Option<f64>> = roots.iter().map(|root| root.bound).collect();
    let real: Vec<Option<f64>> = roots.iter().map(|root| root.real_bound).collect();
    let all = modes.as_slice();
    let of = |value: fn(&eigentone::modes::Mode) -> Option<f64>| -> Vec<f64> {
        let values = all.iter().map(value);
        values.map(|value| value.unwrap_or(f64::NAN)).collect()
    };
    let shapes = Array2::from_shape_fn((n, modes.len()), |(i, k)| all[k].shape()[i]);
    let shape_bounds = Array2::from_shape_fn((n, modes.len()), |(i, k)| {
        all[k].shape_bound().map_or(f64::NAN, |bound| bound[i])
    });
    let own: Vec<Complex<f64>> = all.iter().map(|mode| mode.eigenvalue().value).collect();
    let roots = (
        system.names().to_vec(),
        values.to_pyarray(py),
        numbers(&bounds).to_pyarray(py),
        numbers(&real).to_pyarray(py),
        modes.infinite(),
    );
    let of_modes = (
        own.to_pyarray(py),
        of(|mode| Some(mode.natural_frequency().radians_per_second())).to_pyarray(py),
        of(|mode| mode.damping_ratio()).to_pyarray(py),
        of(|mode| mode.time_constant()).to_pyarray(py),
        all.iter().map(|mode| mode.motion().to_string()).collect(),
        shapes.to_pyarray(py),
        shape_bounds.to_pyarray(py),
    );
    let bounds = worth(modes.bounds());
    (roots, of_modes, bounds, modes.is_complete())
}

/// Modes of M, C and K.
#[pyfunction]
fn modes_of_matrices<'py>(
    py: Python<'py>,
    mass: PyReadonlyArray2<'py, f64>,
    damping: Option<PyReadonlyArray2<'py, f64>>,
    stiffness: PyReadonlyArray2<'py, f64>,
    accuracy: &Bound<'py, PyAny>,
) -> PyResult<ModesAnswer<'py>> {
    let precision = precision(accuracy)?;
    let system = system(&mass, damping.as_ref(), &stiffness)?;
    let modes = py.detach(|| system.modes_to(precision)).map_err(wrong)?;
    Ok(answer(py, &system, &modes))
}

/// Modes of a scene, its text in JSON.
#[pyfunction]
fn modes_of_scene<'py>(
    py: Python<'py>,
    text: &str,
    file: &str,
    accuracy: &Bound<'py, PyAny>,
) -> PyResult<ModesAnswer<'py>> {
    let precision = precision(accuracy)?;
    let scene = scene(text, file)?;
    warn_of_left_out(py, &scene)?;
    let system = scene.system();
    let modes = py.detach(|| system.modes_to(precision)).map_err(wrong)?;
    Ok(answer(py, system, &modes))
}

/// Names; times; displacements and velocities, a row for each coordinate; a bound for each instant of either; names,
/// values and bounds of the outputs; times of the events, how far these may be off, what happens, and to which element of the
/// scene; how sure the bounds are, and the method.
type MotionAnswer<'py> = (
    Vec<String>,
    Vector<'py, f64>,
    Table<'py, f64>,
    Table<'py, f64>,
    Vector<'py, f64>,
    Vector<'py, f64>,
    Vec<(String, Vector<'py, f64>, Vector<'py, f64>)>,
    Vec<(f64, f64, String, String)>,
    &'static str,
    &'static str,
);

/// The motion of a scene.
#[pyfunction]
fn response<'py>(
    py: Python<'py>,
    text: &str,
    file: &str,
    steps: Option<Vec<u64>>,
    accuracy: &Bound<'py, PyAny>,
) -> PyResult<MotionAnswer<'py>> {
    let precision = precision(accuracy)?;
    let scene = scene(text, file)?;
    let places = scene.switch_places();
    let (motion, events) = py.detach(|| -> PyResult<(Trajectory, Vec<Event>)> {
        let problem = scene.problem().ok_or_else(|| {
            wrong("the scene has no \"time\": add \"time\": {\"end\": …, \"step\": …}")
        })?;
        let problem = problem.map_err(wrong)?.to(precision);
        let problem = match &steps {
            None => problem,
            Some(steps) => problem.at(steps).map_err(wrong)?,
        };
        if places.is_empty() {
            let plan = ResponsePlan::of(&problem).map_err(wrong)?;
            return Ok((plan.run(&problem).map_err(wrong)?, Vec::new()));
        }
        let switching = Switching::new(&problem, scene.switches());
        let motion = switching.and_then(|switching| switching.run());
        let motion = motion.map_err(|error| wrong(error.with_names(&places)))?;
        Ok((motion.trajectory().clone(), motion.events().to_vec()))
    })?;
    let names = motion.outputs().map(str::to_owned).collect::<Vec<_>>();
    let outputs = names.into_iter().enumerate().map(|(index, name)| {
        let values = motion.output(index).to_vec().into_pyarray(py);
        let bounds = numbers(motion.output_bound(index)).into_pyarray(py);
        (name, values, bounds)
    });
    let events = events.iter().map(|event| {
        let element = places[event.switch].clone();
        (event.time, event.bound, event.kind.to_string(), element)
    });
    Ok((
        scene.system().names().to_vec(),
        motion.times().to_vec().into_pyarray(py),
        array(motion.displacement()).into_pyarray(py),
        array(motion.velocity()).into_pyarray(py),
        numbers(motion.displacement_bound()).into_pyarray(py),
        numbers(motion.velocity_bound()).into_pyarray(py),
        outputs.collect(),
        events.collect(),
        worth(motion.bounds()),
        motion.method(),
    ))
}

/// From, to, whether that is an output of the scene, values and bounds of each function, and how sure the bounds are.
type FunctionsAnswer<'py> = (
    Vec<(
        String,
        String,
        bool,
        Vector<'py, Complex<f64>>,
        Vector<'py, f64>,
    )>,
    &'static str,
);

/// Frequency response functions of a scene at frequencies in rad/s.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
fn frf<'py>(
    py: Python<'py>,
    text: &str,
    file: &str,
    frequencies: Vec<f64>,
    inputs: Option<Vec<String>>,
    outputs: Option<Vec<String>>,
    of: &Bound<'py, PyAny>,
    accuracy: &Bound<'py, PyAny>,
) -> PyResult<FunctionsAnswer<'py>> {
    let quantities = [
        ("displacement", Quantity::Displacement),
        ("velocity", Quantity::Velocity),
        ("acceleration", Quantity::Acceleration),
    ];
    let (quantity, precision) = (choice("quantity", of, &quantities)?, precision(accuracy)?);
    let scene = scene(text, file)?;
    warn_of_left_out(py, &scene)?;
    let inputs = inputs.unwrap_or_else(|| scene.inputs());
    let asked = scene
        .frequency_response(&inputs, outputs.as_deref())
        .quantity(quantity)
        .precision(precision);
    let found = py.detach(|| asked.at(&frequencies)).map_err(wrong)?;
    let nothing = Complex::new(f64::NAN, f64::NAN);
    let functions = found.functions().iter().map(|function| {
        let known = || function.values().iter().map(|value| value.known());
        let values = known().map(|known| known.map_or(nothing, |(value, _)| value));
        let bounds = known().map(|known| known.and_then(|(_, bound)| bound));
        (
            function.from().to_owned(),
            function.to().to_owned(),
            function.quantity().is_none(),
            values.collect::<Vec<_>>().into_pyarray(py),
            numbers(&bounds.collect::<Vec<_>>()).into_pyarray(py),
        )
    });
    Ok((functions.collect(), worth(found.bounds())))
}

/// e^A, a bound of its error in the 1-norm, and how sure that is.
#[pyfunction]
fn expm<'py>(
    py: Python<'py>,
    a: PyReadonlyArray2<'py, f64>,
) -> PyResult<(Table<'py, f64>, f64, &'static str)> {
    let a = matrix(&a);
    let found = py.detach(|| expm_bounded(a.as_ref())).map_err(wrong)?;
    let matrix = array(found.matrix.as_ref()).into_pyarray(py);
    Ok((matrix, found.bound, worth(found.bounds)))
}

/// Names of states, inputs and outputs, each matrix with the bounds of its entries, and where another derivative of a support is
/// the input.
type StateSpaceAnswer<'py> = (
    Vec<String>,
    Vec<String>,
    Vec<String>,
    Vec<(Table<'py, f64>, Table<'py, f64>)>,
    Vec<String>,
);

/// A, B, C and D of a scene: continuous, or held over a step. Inputs are forces, or motions of supports.
#[pyfunction]
fn state_space<'py>(
    py: Python<'py>,
    text: &str,
    file: &str,
    inputs: Option<Vec<String>>,
    outputs: Option<Vec<String>>,
    held: Option<(f64, Bound<'py, PyAny>)>,
) -> PyResult<StateSpaceAnswer<'py>> {
    let holds = [("zero", Hold::Zero), ("first", Hold::First)];
    let held = match held {
        None => None,
        Some((step, hold)) => Some((step, choice("hold", &hold, &holds)?)),
    };
    let scene = scene(text, file)?;
    if scene.loss_factors().iter().any(|factor| *factor != 0.0) {
        return Err(wrong(
            "a spring with a `loss_factor` has a force for each frequency, but none in time: there is no state-space form",
        ));
    }
    let inputs = inputs.unwrap_or_else(|| scene.inputs());
    let form = py.detach(|| scene.state_space(&inputs, outputs.as_deref()));
    let (plant, mut said) = form.map_err(wrong)?;
    said.extend(left_out(&scene).map(|note| note.to_string_lossy().into_owned()));
    let discrete = match held {
        None => None,
        Some((step, hold)) => {
            let held = py.detach(|| plant.discretise(step, hold)).map_err(wrong)?;
            Some(held)
        }
    };
    let matrices = discrete.as_ref().unwrap_or(plant.matrices());
    let both = |matrix: &BoundedMatrix| {
        let values = array(matrix.values.as_ref()).into_pyarray(py);
        (values, array(matrix.bound.as_ref()).into_pyarray(py))
    };
    let matrices = [&matrices.a, &matrices.b, &matrices.c, &matrices.d];
    Ok((
        plant.states().to_vec(),
        plant.inputs().to_vec(),
        plant.outputs().to_vec(),
        matrices.map(both).into(),
        said,
    ))
}

/// The compiled part of the package.
#[pymodule]
fn _eigentone(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(modes_of_matrices, module)?)?;
    module.add_function(wrap_pyfunction!(modes_of_scene, module)?)?;
    module.add_function(wrap_pyfunction!(response, module)?)?;
    module.add_function(wrap_pyfunction!(frf, module)?)?;
    module.add_function(wrap_pyfunction!(expm, module)?)?;
    module.add_function(wrap_pyfunction!(state_space, module)?)
}
