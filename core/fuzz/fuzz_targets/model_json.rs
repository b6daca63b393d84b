//! [`Model::from_json`] on arbitrary text; what passes is read back from its binary form, and run.
#![no_main]

use ballrace_core::model::Model;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let mut storage = vec![[0; 4]; 4096];
    if let Ok(model) = Model::from_json(text, &mut storage) {
        let mut bytes = vec![0; model.byte_len()];
        model.to_bytes(&mut bytes).unwrap();
        assert_eq!(Model::from_bytes(&bytes), Ok(model.clone()));
        ballrace_core_fuzz::run(&model, text.as_bytes());
    }
    // Too little storage is an error.
    let _ = Model::from_json(text, &mut [[0; 4]; 16]);
});
