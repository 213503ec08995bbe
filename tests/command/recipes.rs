//! Recipes: any command line, saved and run again.

use super::inputs::{bytes, desk};
use crate::common::program::relievo;
use std::fs;

#[test]
fn a_recipe_is_the_command_line_it_was_made_of() {
    let desk = desk(1..=1);
    let here = desk.path();
    let flags = "--light 135,40 --light 20,30,1,0.5,0.25 --material phong --specular-gain 0.5 --scale 2.5 \
        --silhouette 0.05,0.06 --thin --contrast -0.25";
    let words = format!("relight in.0001.exr {flags} -o one.png --save-recipe look.toml");
    relievo(here, &words).ended(0);
    let recipe = fs::read_to_string(here.join("look.toml")).unwrap();
    for line in [
        "version = 1",
        "command = \"relight\"",
        "light = [\"135,40\", \"20,30,1,0.5,0.25\"]",
        "thin = true",
        "contrast = -0.25",
    ] {
        assert!(recipe.lines().any(|l| l == line), "{line} in\n{recipe}");
    }
    // It includes automatically chosen values.
    assert!(recipe.contains("curvature-gain = "), "{recipe}");
    relievo(here, "run look.toml in.0001.exr -o two.png").ended(0);
    assert!(bytes(here, "one.png") == bytes(here, "two.png"));

    // The command line overrides it; conflicting keys are dropped.
    relievo(
        here,
        "run look.toml in.0001.exr -o three.png --contrast 0.5 --iterations 4",
    )
    .ended(0);
    let typed = flags
        .replace("--contrast -0.25", "--contrast 0.5")
        .replace("--scale 2.5", "--iterations 4");
    let [gain, exposure] = ["curvature-gain", "exposure"].map(|name| {
        let value = |line: &str| Some(line.strip_prefix(name)?.strip_prefix(" = ")?.to_string());
        recipe.lines().find_map(value).unwrap()
    });
    let chosen = format!("--curvature-gain {gain} --exposure {exposure}");
    let words = format!("relight in.0001.exr {typed} {chosen} -o four.png");
    relievo(here, &words).ended(0);
    assert!(bytes(here, "three.png") == bytes(here, "four.png"));
}

#[test]
fn lights_of_the_command_line_replace_those_of_the_recipe() {
    let desk = desk(1..=1);
    let here = desk.path();
    let recipe =
        "version = 1\ncommand = \"relight\"\nlight = [[135, 40], [10, 10]]\ncurvature-gain = 2";
    fs::write(here.join("look.toml"), recipe).unwrap();
    relievo(here, "run look.toml in.0001.exr --light 90,60 -o one.png").ended(0);
    let words = "relight in.0001.exr --light 90,60 --curvature-gain 2 -o two.png";
    relievo(here, words).ended(0);
    assert!(bytes(here, "one.png") == bytes(here, "two.png"));
}

#[test]
fn a_recipe_that_cannot_be_used_is_refused_in_one_line() {
    let desk = desk(1..=1);
    let here = desk.path();
    for (text, expected) in [
        (
            "version = 1\ncommand = \"enhance\"\nscallng = 2",
            "the nearest is scaling",
        ),
        (
            "version = 1\ncommand = \"enhance\"\nscaling = \"much\"",
            "scaling",
        ),
        ("command = \"enhance\"", "add version = 1"),
        ("version = 1\nscaling = ", "line 2"),
        ("\u{0}", "line 1"),
    ] {
        fs::write(here.join("look.toml"), text).unwrap();
        let said = relievo(here, "run look.toml in.0001.exr -o out.png").ended(2);
        assert!(
            said.contains(expected) && said.lines().count() == 1,
            "{said}"
        );
    }
    let said = relievo(here, "run none.toml in.0001.exr -o out.png").ended(1);
    assert!(said.contains("none.toml: cannot read"), "{said}");
    assert!(!here.join("out.png").exists());
}

#[test]
fn the_recipe_is_recorded_in_the_output() {
    let desk = desk(1..=1);
    let here = desk.path();
    relievo(
        here,
        "enhance in.0001.exr --scaling 1.5 -o out.exr --layers results",
    )
    .ended(0);
    let file = relievo::io::exr::ExrFile::open(&here.join("out.exr"), &Default::default()).unwrap();
    let recipe = &file.attributes["relievo.recipe"];
    assert!(
        recipe.contains("scaling = 1.5") && recipe.contains("white-level = "),
        "{recipe}"
    );
    assert!(file.attributes["software"].starts_with("relievo "));
    // It can be extracted and run.
    fs::write(here.join("look.toml"), recipe).unwrap();
    relievo(
        here,
        "run look.toml in.0001.exr -o again.exr --layers results",
    )
    .ended(0);
    assert!(bytes(here, "again.exr") == bytes(here, "out.exr"));
}

#[test]
fn what_was_chosen_is_for_the_same_frames() {
    let desk = desk(1..=3);
    let here = desk.path();
    fs::rename(here.join("in.0003.exr"), here.join("other.exr")).unwrap();
    relievo(
        here,
        "enhance in.0001.exr --scaling 1.5 -o a.png --save-recipe look.toml",
    )
    .ended(0);
    let recipe = fs::read_to_string(here.join("look.toml")).unwrap();
    let (look, chosen) = recipe.split_once("[chosen]\n").unwrap();
    assert!(
        !look.contains("level") && !look.contains("normal"),
        "{look}"
    );
    assert!(
        chosen.contains("frames = \"in.#.exr\"") && chosen.contains("normal-space = "),
        "{chosen}"
    );
    let picture = |words: &str| {
        let said = relievo(here, &format!("{words} -o out.png")).ended(0);
        (bytes(here, "out.png"), said)
    };
    let level = |name: &str| {
        let line = chosen
            .lines()
            .find_map(|line| line.strip_prefix(&format!("{name} = ")));
        format!("--{name} {}", line.unwrap())
    };
    let levels = ["curvature-gain", "white-level"].map(level).join(" ");
    // With the levels of the first frame, and with its own.
    let [other, second] = ["other.exr", "in.0002.exr"].map(|input| {
        let enhanced = format!("enhance {input} --scaling 1.5");
        let both = [format!("{enhanced} {levels}"), enhanced].map(|words| picture(&words).0);
        assert!(both[0] != both[1], "{input}");
        both
    });
    // Another file chooses anew, and reports it; the same frames do not.
    let (made, said) = picture("run look.toml other.exr");
    assert!(made == other[1] && said.contains("--keep-levels"), "{said}");
    let (made, said) = picture("run look.toml other.exr --keep-levels");
    assert!(
        made == other[0] && !said.contains("--keep-levels"),
        "{said}"
    );
    assert!(picture("run look.toml in.0002.exr").0 == second[0]);
}

#[test]
fn the_schema_knows_every_setting() {
    let desk = tempfile::tempdir().unwrap();
    let schema = relievo(desk.path(), "schema").done().stdout;
    let schema: serde_json::Value = serde_json::from_str(&schema).unwrap();
    let commands = schema["oneOf"].as_array().unwrap();
    let titles: Vec<_> = commands
        .iter()
        .map(|c| c["title"].as_str().unwrap())
        .collect();
    assert_eq!(
        titles,
        ["shape", "enhance", "relight", "hatch", "map", "normals"]
    );
    let relight = &commands[2]["properties"];
    assert_eq!(relight["ior"]["type"], "number");
    assert_eq!(relight["ior"]["default"], "1.5");
    assert_eq!(relight["thin"]["type"], "boolean");
    assert_eq!(relight["method"]["enum"][1], "warp");
    assert!(relight["light"]["anyOf"].is_array());
    assert!(relight["threads"].is_null() && relight["output"].is_null());
}
