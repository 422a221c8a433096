//! Any bytes as a Matrix Market file.

#![no_main]

use std::cell::RefCell;
use std::fs;
use std::path::PathBuf;

use eigentone::scene::Scene;
use libfuzzer_sys::fuzz_target;

const SCENE: &str = r#"{"matrices": {"mass": "fuzzed.mtx", "stiffness": "fuzzed.mtx"}}"#;

thread_local! {
    /// The file beside the scene, in a folder of this process.
    static FILE: RefCell<Option<PathBuf>> = const { RefCell::new(None) };
}

fuzz_target!(|bytes: &[u8]| {
    FILE.with_borrow_mut(|file| {
        let file = file.get_or_insert_with(|| {
            let name = format!("eigentone-fuzz-{}", std::process::id());
            let folder = std::env::temp_dir().join(name);
            fs::create_dir_all(&folder).expect("a folder for temporary files");
            folder.join("fuzzed.mtx")
        });
        fs::write(&*file, bytes).expect("a temporary file");
        if let Err(error) = Scene::parse(SCENE, &file.with_file_name("scene.json")) {
            let message = error.to_string();
            assert!(!message.contains('\n') && message.len() < 1000, "{message}");
        }
    });
});
