//! What is played and looked through where a file has several of it.

use super::*;

fn says(error: ReadError, words: &[&str]) {
    let error = error.to_string();
    assert!(words.iter().all(|word| error.contains(word)), "{error}");
}

fn playing(picks: &[Pick]) -> Choice {
    Choice { animations: picks.to_vec(), ..Choice::default() }
}

fn name(name: &str) -> Pick {
    Pick::Name(name.into())
}

#[test]
fn an_animation_is_chosen_by_its_name() {
    let mut file = one_node(json!({}));
    file.animate(0, "translation", "LINEAR", &[0.0], &[1.0, 0.0, 0.0]);
    file.animate(0, "translation", "LINEAR", &[0.0, 2.0], &[2.0, 0.0, 0.0, 2.0, 0.0, 0.0]);
    file.root["animations"][1]["name"] = "Fly".into();
    let x = |choice: &Choice| pose(&open_as(&file, choice).unwrap(), 0.0)[0][0];
    assert_eq!([Choice::default(), named("0"), named("Fly")].each_ref().map(x), [2.0, 2.0, 3.0]);
    let names = [("0", 0.0), ("Fly", 2.0)].map(|(name, seconds)| Animation { name: name.into(), seconds });
    assert_eq!(open(&file).unwrap().animations(), names);
    let error = open_as(&file, &named("fly")).unwrap_err();
    says(error, &["mesh.gltf: animations: none is called `fly`", "`0`, `Fly`, or a number from 0 to 1"]);
    let error = open_as(&one_node(json!({})), &named("Fly")).unwrap_err();
    says(error, &["none is called `Fly`", "has none"]);
    let error = open_as(&one_node(json!({})), &named("*")).unwrap_err();
    says(error, &["none is called `*`", "has none"]);
}

/// [`one_node`] with three animations: two called `Move`, along x and along y, and one that is called nothing, along x.
fn three_animations() -> GltfFile {
    let mut file = one_node(json!({}));
    file.animate(0, "translation", "LINEAR", &[0.0], &[1.0, 0.0, 0.0]);
    file.animate(0, "scale", "LINEAR", &[0.0], &[2.0, 2.0, 2.0]);
    file.animate(0, "translation", "LINEAR", &[0.0], &[4.0, 0.0, 0.0]);
    file.root["animations"][0]["name"] = "Move".into();
    file.root["animations"][1]["name"] = "Move".into();
    file
}

#[test]
fn equal_names_and_none_are_told_apart_by_number() {
    let file = three_animations();
    let of = |pick: Pick| {
        let mesh = open_as(&file, &playing(&[pick])).unwrap();
        (pose(&mesh, 0.0)[0][0], mesh.notes().len())
    };
    assert_eq!([0, 1, 2].map(Pick::Number).map(of), [(2.0, 0), (2.0, 0), (5.0, 0)]);
    assert_eq!([name("2"), name("Move")].map(of), [(5.0, 0), (2.0, 1)]);
    let mesh = open_as(&file, &named("Move")).unwrap();
    assert_eq!(notes(&mesh), ["2 animations are called `Move`: number 0 is played"]);
    says(open_as(&file, &playing(&[Pick::Number(3)])).unwrap_err(), &["no number 3", "`Move`, `Move`, `2`", "0 to 2"]);
    let one = |picks: &[Pick]| {
        let mut file = one_node(json!({}));
        file.animate(0, "translation", "LINEAR", &[0.0], &[1.0, 0.0, 0.0]);
        open_as(&file, &playing(picks)).unwrap_err()
    };
    says(one(&[Pick::Number(0), Pick::Number(1)]), &["no number 1", "`0` or 0, the only one"]);
}

#[test]
fn several_animations_are_played_at_once() {
    let mut file = three_animations();
    let of = |file: &GltfFile, picks: &[Pick]| {
        let mesh = open_as(file, &playing(picks)).unwrap();
        let overlaps = notes(&mesh).iter().any(|note| note.contains("move the same"));
        (pose(&mesh, 0.0)[0][0], overlaps, mesh.playing().count())
    };
    let [first, second, third] = [0, 1, 2].map(Pick::Number);
    assert_eq!(of(&file, &[first.clone(), second.clone()]), (3.0, false, 2));
    // Of two that move the same, the later one.
    assert_eq!(of(&file, &[first.clone(), third.clone()]), (5.0, true, 2));
    assert_eq!(of(&file, &[third, second, first]), (3.0, true, 3));
    assert_eq!(of(&file, &[name("*")]), (6.0, true, 3));
    file.root["animations"][0]["name"] = "*".into();
    assert_eq!(of(&file, &[name("*")]), (2.0, false, 1));
}

/// A mesh, and cameras `Main` and `Side` in nodes of their own, of which the second hangs on a node that is called `Rig`.
/// Each of the four nodes has an animation that moves it along x by its number plus one.
fn filmed() -> GltfFile {
    let mut file = one_node(json!({"name": "Box"}));
    file.add("nodes", json!({"camera": 0, "name": "Main"}));
    file.add("nodes", json!({"children": [3], "name": "Rig"}));
    file.add("nodes", json!({"camera": 1}));
    file.root["scenes"] = json!([{"nodes": [0, 1, 2]}]);
    file.root["cameras"] = json!([
        {"type": "perspective", "name": "Lens", "perspective": {"yfov": 1, "znear": 0.25}},
        {"type": "perspective", "name": "Side", "perspective": {"yfov": 0.5, "znear": 0.5, "zfar": 7}},
    ]);
    for node in 0..3 {
        file.animate(node, "translation", "LINEAR", &[0.0], &[node as f32 + 1.0, 0.0, 0.0]);
        file.root["animations"][node]["name"] = ["BoxAction", "MainAction", "RigAction"][node].into();
    }
    file
}

fn looking(animations: &[Pick], camera: Option<Pick>) -> Choice {
    Choice { animations: animations.to_vec(), camera, for_camera: true }
}

#[test]
fn a_camera_is_moved_by_what_moves_it() {
    let file = filmed();
    let eye = |choice: Choice| open_as(&file, &choice).unwrap().camera(0.0).unwrap().eye.x;
    // Whatever is played of the rest, in whatever order.
    for animations in [&[][..], &[name("BoxAction")], &[Pick::Number(0), Pick::Number(2)], &[name("MainAction")]] {
        assert_eq!(eye(looking(animations, None)), 2.0, "{animations:?}");
    }
    assert_eq!(eye(looking(&[name("*")], None)), 2.0);
    // By the node that it hangs on, too.
    assert_eq!(eye(looking(&[], Some(name("Side")))), 3.0);
    assert_eq!(eye(looking(&[name("MainAction")], Some(name("Side")))), 3.0);
    // Of several that move it, the one that is asked for.
    let mut takes = filmed();
    takes.animate(1, "translation", "LINEAR", &[0.0], &[9.0, 0.0, 0.0]);
    let eye = |choice| open_as(&takes, &choice).unwrap().camera(0.0).unwrap().eye.x;
    assert_eq!([eye(looking(&[], None)), eye(looking(&[Pick::Number(3)], None))], [2.0, 9.0]);
    // Without that wish only what is asked for moves.
    let still = Choice { for_camera: false, ..looking(&[Pick::Number(0)], None) };
    assert_eq!(open_as(&takes, &still).unwrap().camera(0.0).unwrap().eye.x, 0.0);
}

#[test]
fn a_camera_is_chosen_by_name_or_number() {
    let file = filmed();
    let of = |pick: Option<Pick>| {
        let mesh = open_as(&file, &Choice { camera: pick, ..Choice::default() }).unwrap();
        (mesh.camera(0.0).unwrap().near, mesh.camera_taken().unwrap().name.clone())
    };
    let (main, side) = ((0.25, "Main".to_owned()), (0.5, "Side".to_owned()));
    for pick in [None, Some(name("Main")), Some(name("Lens")), Some(Pick::Number(0))] {
        assert_eq!(of(pick), main);
    }
    for pick in [name("Side"), Pick::Number(1)] {
        assert_eq!(of(Some(pick)), side);
    }
    let error = |pick| open_as(&file, &Choice { camera: Some(pick), ..Choice::default() }).unwrap_err();
    says(error(name("Top")), &["mesh.gltf: cameras: none is called `Top`", "`Main`, `Side`, or a number from 0 to 1"]);
    says(error(Pick::Number(2)), &["cameras: there is no number 2"]);
    let none = open_as(&one_node(json!({})), &Choice { camera: Some(name("Top")), ..Choice::default() });
    says(none.unwrap_err(), &["none is called `Top`", "a file with cameras; this one has none"]);
}

#[test]
fn orthographic_cameras_are_looked_through_where_there_is_no_other() {
    let mut file = filmed();
    let orthographic = json!({"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "zfar": 2, "znear": 1}});
    file.root["cameras"][0] = orthographic.clone();
    // The one beside it is used.
    let mesh = open(&file).unwrap();
    assert_eq!(mesh.camera_taken().unwrap().name, "Side");
    assert_eq!(mesh.cameras().iter().map(|camera| camera.is_perspective).collect::<Vec<_>>(), [false, true]);
    let choice = Choice { camera: Some(name("Main")), ..Choice::default() };
    assert_eq!(open_as(&file, &choice).unwrap().camera(0.0).unwrap().orthographic, Some(2.0));
    file.root["cameras"][1] = orthographic;
    assert_eq!(open(&file).unwrap().camera_taken().unwrap().name, "Main");
    // For the mesh alone no camera is needed.
    file.root["cameras"] = json!([{"type": "orthographic"}, {"type": "fisheye"}]);
    assert_eq!(open(&file).unwrap().camera(0.0), None);
    says(open_as(&file, &choice).unwrap_err(), &["camera `Main`: does not say what it sees", "`orthographic`"]);
}
