//! `relievo report` with a device beside the CPU.

use super::command::program_without_adapters;
use super::on_gpu;
use crate::common::program::{Ran, fixture, program};
use relievo::product::Product;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// Reports on a frame with these further words, into `desk`.
fn report(desk: &Path, words: &str, adapters: bool) -> Ran {
    let mut program = match adapters {
        true => program(desk),
        false => program_without_adapters(desk),
    };
    program
        .arg("report")
        .arg(fixture("bust.exr"))
        .args(["-o", "report", "--quick", "--quiet"])
        .args(words.split_whitespace());
    Ran::of(&mut program).done()
}

fn read(desk: &Path) -> (String, Value) {
    let text = |name| fs::read_to_string(desk.join("report").join(name)).unwrap();
    (
        text("report.md"),
        serde_json::from_str(&text("report.json")).unwrap(),
    )
}

fn number(value: &Value) -> f64 {
    let number = value.as_f64();
    number.unwrap_or_else(|| panic!("{value} is no number"))
}

/// Every scale of the frame and of every scene.
fn scales(json: &Value) -> Vec<&Value> {
    let scenes = json["scenes"].as_array().unwrap();
    let sweeps = std::iter::once(&json["frame"]).chain(scenes);
    let scales = sweeps.flat_map(|sweep| sweep["scales"].as_array().unwrap());
    scales.collect()
}

#[test]
fn a_device_has_rows_beside_the_cpu_and_its_products_are_within_the_table() {
    on_gpu(|runner| {
        let desk = tempfile::tempdir().unwrap();
        report(desk.path(), "--backend gpu", true);
        let (page, json) = read(desk.path());
        let told = &json["gpu"]["measured"];
        assert_eq!(told["device"], runner.device().name());
        let products = told["products"].as_array().unwrap();
        assert!(!products.is_empty() && products.len() <= Product::all().count());
        for product in products {
            assert_eq!(product["is_within"], true, "{product}");
            assert!(number(&product["difference"]) <= number(&product["tolerance"]));
        }
        for scale in scales(&json) {
            let on_gpu = scale["on_gpu"].as_array().unwrap();
            let asked = on_gpu.iter().find(|row| row["asked_for"] == true);
            let asked = asked.unwrap_or_else(|| panic!("{}", scale["scale"]));
            let rows = scale["rows"].as_array().unwrap();
            let on_cpu = rows.iter().find(|row| row["asked_for"] == true).unwrap();
            // The same expansion, rounded in other places.
            let [found, expected] = [asked, on_cpu].map(|row| number(&row["gradient"]["max"]));
            assert!((found - expected).abs() < 1e-5, "{found}, not {expected}");
            for row in on_gpu {
                let least = |name: &str| number(&row[name]["min"]);
                let parts = [least("upload"), least("compute"), least("read_back")];
                assert!(parts.iter().all(|&time| time > 0.0), "{parts:?}");
                assert!(parts.iter().sum::<f64>() <= 1.001 * least("whole"));
                let stages = row["stages"].as_array().unwrap();
                let sum = stages.iter().map(|stage| number(&stage["times"]["min"]));
                assert!(sum.sum::<f64>() <= 1.001 * least("compute"), "{row}");
                if runner.device().has_clock() {
                    let has = |name: &str| stages.iter().any(|stage| stage["stage"] == name);
                    assert!(has("edges-and-gradient") && has("diffusion"), "{stages:?}");
                }
            }
        }
        let pictures = told["pictures"].as_array().unwrap();
        assert_eq!(pictures.len(), 3);
        for picture in pictures {
            let on_gpu = &picture["on_gpu"];
            let least = |name: &str| number(&on_gpu[name]["min"]);
            let parts = [least("upload"), least("compute"), least("read_back")];
            assert!(parts.iter().all(|&time| time > 0.0), "{parts:?}");
            assert!(parts.iter().sum::<f64>() <= 1.001 * least("whole"));
            assert!(number(&picture["on_cpu"]["whole"]["min"]) > 0.0);
            let mean = |by: &str| &picture[by]["errors"]["mean"];
            match picture["reference"].as_str().unwrap() {
                // Both round as often, in other places.
                "double-precision" => {
                    let [found, expected] = [mean("on_gpu"), mean("on_cpu")].map(number);
                    assert!(found > 0.0 && found < 2.0 * expected, "{picture}");
                }
                _ => assert!(number(mean("on_gpu")) <= Product::Strokes.tolerance()),
            }
        }
        assert!(page.contains("| 54 lights, warped | GPU | double precision |"));
        assert!(page.contains("| hatching with contours, pen | GPU | the CPU |"));
        let plot = fs::read_to_string(desk.path().join("report/pictures.svg")).unwrap();
        assert!(plot.contains("one lamp, scaled"));
        assert!(page.contains("## On a GPU") && page.contains("| Chebyshev, GPU |"));
        assert!(page.contains(&runner.device().name()) && page.contains("| mapped curvature |"));
        let plot = fs::read_to_string(desk.path().join("report/frame.svg")).unwrap();
        assert!(plot.contains("on the GPU") && plot.contains("<polygon"));
    });
}

#[cfg(target_os = "linux")]
#[test]
fn without_a_device_the_report_says_that_none_was_measured() {
    let desk = tempfile::tempdir().unwrap();
    report(desk.path(), "", false);
    let (page, json) = read(desk.path());
    let why = json["gpu"]["not_measured"].as_str().unwrap();
    assert!(why.contains("no adapter"), "{why}");
    let lines = page
        .lines()
        .filter(|line| line.contains("None was measured"));
    assert_eq!(lines.count(), 1);
    assert!(!page.contains(", GPU |") && !page.contains("pictures.svg"));
    for scale in scales(&json) {
        assert!(scale.get("on_gpu").is_none());
    }
}
