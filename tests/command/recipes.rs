//! Recipes: any command line, saved and run again.

use crate::common::program::{Desk, tells};
use std::fs;

#[test]
fn a_recipe_is_the_command_line_it_was_made_of() {
    let desk = Desk::of_frames(1..=1);
    let flags = "--light 135,40 --light 20,30,1,0.5,0.25 --material phong --specular-gain 0.5 --scale 2.5 \
        --silhouette 0.05,0.06 --thin --contrast -0.25";
    let words = format!("relight in.0001.exr {flags} -o one.png --save-recipe look.toml");
    desk.make(&words);
    let recipe = desk.text("look.toml");
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
    desk.make("run look.toml in.0001.exr -o two.png");
    assert!(desk.shown("one.png") == desk.shown("two.png"));

    // The command line overrides it; conflicting keys are dropped.
    desk.make("run look.toml in.0001.exr -o three.png --contrast 0.5 --iterations 4");
    let typed = flags
        .replace("--contrast -0.25", "--contrast 0.5")
        .replace("--scale 2.5", "--iterations 4");
    let [gain, exposure] = ["curvature-gain", "exposure"].map(|name| {
        let value = |line: &str| Some(line.strip_prefix(name)?.strip_prefix(" = ")?.to_string());
        recipe.lines().find_map(value).unwrap()
    });
    let chosen = format!("--curvature-gain {gain} --exposure {exposure}");
    let words = format!("relight in.0001.exr {typed} {chosen} -o four.png");
    desk.make(&words);
    assert!(desk.shown("three.png") == desk.shown("four.png"));
}

#[test]
fn lights_of_the_command_line_replace_those_of_the_recipe() {
    let desk = Desk::of_frames(1..=1);
    let recipe = "version = 1\ncommand = \"relight\"\nlight = [[135, 40], [10, 10]]";
    desk.write("look.toml", format!("{recipe}\ncurvature-gain = 2"));
    desk.make("run look.toml in.0001.exr --light 90,60 -o one.png");
    let words = "relight in.0001.exr --light 90,60 --curvature-gain 2 -o two.png";
    desk.make(words);
    assert!(desk.shown("one.png") == desk.shown("two.png"));
}

#[test]
fn a_recipe_that_cannot_be_used_is_refused_in_one_line() {
    let desk = Desk::of_frames(1..=1);
    let look = "version = 1\ncommand = \"enhance\"\n";
    for (text, row) in [
        (format!("{look}scallng = 2"), "=> 2: the nearest is scaling"),
        (format!("{look}scaling = \"much\""), "=> 2: scaling"),
        ("command = \"enhance\"".into(), "=> 2: add version = 1"),
        ("version = 1\nscaling = ".into(), "=> 2: line 2"),
        ("\u{0}".into(), "=> 2: line 1"),
    ] {
        desk.write("look.toml", text);
        desk.check("run look.toml in.0001.exr -o out.png", row);
    }
    let row = "=> 1: none.toml: cannot read";
    desk.check("run none.toml in.0001.exr -o out.png", row);
}

#[test]
fn the_recipe_is_recorded_in_the_output() {
    let desk = Desk::of_frames(1..=1);
    desk.make("enhance in.0001.exr --scaling 1.5 -o out.exr --layers results");
    let file = desk.exr("out.exr");
    let recipe = &file.attributes["relievo.recipe"];
    tells(recipe, "scaling = 1.5 ... white-level = ");
    assert!(file.attributes["software"].starts_with("relievo "));
    // It can be extracted and run.
    desk.write("look.toml", recipe);
    desk.make("run look.toml in.0001.exr -o again.exr --layers results");
    assert!(desk.shown("again.exr") == desk.shown("out.exr"));
}

#[test]
fn what_was_chosen_is_for_the_same_frames() {
    let desk = Desk::of_frames(1..=3);
    fs::rename(desk.at("in.0003.exr"), desk.at("other.exr")).unwrap();
    desk.make("enhance in.0001.exr --scaling 1.5 -o a.png --save-recipe look.toml");
    let recipe = desk.text("look.toml");
    let (look, chosen) = recipe.split_once("[chosen]\n").unwrap();
    tells(look, "!level ... !normal");
    tells(chosen, "frames = \"in.#.exr\" ... normal-space = ");
    let picture = |words: &str| {
        let said = desk.make(format!("{words} -o out.png")).stderr;
        (desk.shown("out.png"), said)
    };
    let level = |name: &str| {
        let key = format!("{name} = ");
        let value = chosen.lines().find_map(|line| line.strip_prefix(&key));
        format!("--{name} {}", value.unwrap())
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
    assert!(made == other[0] && !said.contains("--keep-levels"));
    assert!(picture("run look.toml in.0002.exr").0 == second[0]);
}

#[test]
fn the_schema_knows_every_setting() {
    let desk = Desk::new();
    let schema = desk.make("schema").stdout;
    let schema: serde_json::Value = serde_json::from_str(&schema).unwrap();
    let commands = schema["oneOf"].as_array().unwrap();
    let titles: Vec<_> = commands.iter().map(|c| &c["title"]).collect();
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
