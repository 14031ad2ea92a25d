# celfx: make build, make demo, make test, make test-all, make bench, make bench-gpu,
# make shaders. Each first runs .ci/setup, which installs what is missing.

export PATH := $(or $(CARGO_HOME),$(HOME)/.cargo)/bin:$(PATH)

CELFX = $(or $(CARGO_TARGET_DIR),target)/release/celfx

# Tests run on lavapipe even where there is a GPU, so that they see the same driver everywhere.
# On another driver: make test DRIVER=/path/to/its_icd.json; on whatever the loader finds: make test DRIVER=
DRIVER = $(firstword $(wildcard $(addsuffix /vulkan/icd.d/lvp_icd*.json,/usr/share /usr/local/share /etc)))
ON_DRIVER = $(if $(DRIVER),VK_DRIVER_FILES=$(DRIVER) VK_ICD_FILENAMES=$(DRIVER))

.PHONY: build demo test test-all bench bench-gpu shaders clean setup

build: setup
	cargo build --release --locked

demo: build
	mkdir -p demo
	for shot in smoke flame campfire blur; do \
	  $(CELFX) render builtin:$$shot -o demo/$$shot/%04d.png --sheet demo/$$shot.png --animation demo/$$shot.gif || exit; \
	done
	@echo "For each of smoke, flame, campfire and blur: frames in demo/smoke/ and so on, side by side in demo/smoke.png, moving in demo/smoke.gif."

# The dev profile and not release: it checks integer overflow and debug assertions. Its opt-level is 1 (Cargo.toml),
# fast enough for the references.
test: setup
	cargo fmt --check
	cargo clippy --locked --all-targets -- -D warnings
	cargo clippy --locked --no-default-features -- -D warnings
	$(ON_DRIVER) CELFX_REQUIRE_VULKAN=1 cargo test --locked

# The documentation without a warning, and the tests that take minutes, too: memory over 500 frames of each effect, each
# Vulkan call failing in turn; views of OpenColorIO, what others read of what celfx writes, and farms on this machine, where what that
# takes can be installed; and, where SwiftShader is installed, every pipeline compiled by it, prefix sums, the fire in every
# shape of its kernels, hosts, and pictures in larger images.
SWIFTSHADER = $(wildcard /usr/lib/chromium/vk_swiftshader_icd.json)

test-all: test
	RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps --no-default-features
	RUSTDOCFLAGS="-D warnings" cargo doc --locked --no-deps
	$(ON_DRIVER) CELFX_REQUIRE_VULKAN=1 cargo test --locked -- --ignored
	cargo clippy --locked --features ocio -- -D warnings
	cargo test --locked --features ocio --lib display
	cargo build --release --locked --features ocio --target-dir target/ocio
	$(ON_DRIVER) tests/decoders.sh target/ocio/release/celfx
	$(ON_DRIVER) tests/farm.sh target/ocio/release/celfx
	$(if $(SWIFTSHADER),export VK_DRIVER_FILES=$(SWIFTSHADER) VK_ICD_FILENAMES=$(SWIFTSHADER) && \
	  cargo test --locked --test kernels -- --ignored --nocapture && \
	  cargo test --locked --test flame shapes && cargo test --locked --test scan && \
	  cargo test --locked --test embed --test contract && cargo test --locked --test blur larger,\
	  @echo "SKIPPED: no SwiftShader here; on Debian: apt install chromium-common")

bench: build
	$(CELFX) bench all -o bench

# On the GPU that the loader finds: all tests, what kernels cost and which ways are the fastest, and the benchmark, which
# docs/performance-DEVICE.md keeps.
bench-gpu: build
	@$(CELFX) info | grep -E '^\*.*GPU\)' || { echo "no GPU: celfx info shows what there is, and what it lacks"; exit 1; }
	CELFX_REQUIRE_VULKAN=1 cargo test --locked
	-$(CELFX) info --kernels
	$(CELFX) bench calibrate | tee bench-gpu-tuning.toml
	$(CELFX) bench all -o bench-gpu --page docs

# Writes the SPIR-V that travels in the package, shaders/, anew.
shaders: setup
	CELFX_WRITE_SHADERS=1 cargo test --locked --test shipped the_shipped_shaders

clean:
	cargo clean
	rm -rf .shaderc demo bench bench-gpu bench-gpu-tuning.toml

setup:
	@.ci/setup
