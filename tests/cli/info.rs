//! `celfx info`: devices, and what kernels cost on one.

use super::run::{Folder, celfx, has_device};
use super::succeeds;

#[test]
fn info_lists_the_devices_for_people_and_scripts() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    let report: serde_json::Value = serde_json::from_str(&succeeds(&folder, &["info", "--json"])).expect("JSON");
    let devices = report["devices"].as_array().expect("devices");
    assert!(devices.iter().any(|d| d["used"] == true && d["lacks"] == serde_json::json!([])), "{report}");
    let text = succeeds(&folder, &["info"]);
    assert!(devices.iter().all(|d| text.contains(d["name"].as_str().expect("a name"))), "{text}");
}

/// Of a device that says so, or of Mesa's RADV, which compiles for a chip that is not there.
#[test]
fn info_says_what_kernels_cost_where_the_driver_does() {
    if !has_device() {
        return;
    }
    let folder = Folder::new();
    let lacks = celfx(&folder, &["info", "--kernels"]).output().expect("the program runs");
    let text = String::from_utf8_lossy(&lacks.stderr);
    assert!(lacks.status.success() || text.contains("lacks VK_KHR_pipeline_executable_properties"), "{text}");
    assert!(lacks.status.success() || lacks.status.code() == Some(4), "{:?}", lacks.status);

    let driver = "/usr/share/vulkan/icd.d/radeon_icd.x86_64.json";
    if !std::path::Path::new(driver).exists() {
        return eprintln!("SKIPPED, no RADV");
    }
    let mut command = celfx(&folder, &["info", "--kernels", "--json"]);
    command.env_remove("VK_ICD_FILENAMES").env("VK_DRIVER_FILES", driver).env("RADV_FORCE_FAMILY", "NAVI21");
    let output = command.output().expect("the program runs");
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let kernels = report["kernels"].as_array().expect("kernels");
    for effect in ["smoke", "flame", "blur"] {
        let own = kernels.iter().filter(|k| k["pass"].as_str().is_some_and(|pass| pass.starts_with(effect)));
        assert!(own.count() > 20, "{effect}: {report}");
    }
    for executable in kernels.iter().flat_map(|kernel| kernel["executables"].as_array().expect("executables")) {
        for figure in ["registers", "spilled", "scratch_bytes", "shared_bytes", "subgroups", "code_bytes"] {
            assert!(executable[figure].is_number(), "{figure}: {executable}");
        }
    }
}
