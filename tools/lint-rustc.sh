#!/bin/sh
# Compiles one of our crates with clippy's lints, and makes its documentation, all warnings errors: RUSTC_WORKSPACE_WRAPPER
# of `make test`. What tests need is compiled in any case; by `cargo clippy` and `cargo doc` all of it is read twice more.
set -eu
rustc=$1
shift
clippy-driver "$rustc" "$@" -D warnings
case " $* " in
*" --crate-name ___ "* | *" --crate-name build_script_"*) exit ;; # cargo's question what the compiler is; no crate of ours
*" --crate-type lib "*) ;;
*" --crate-type bin "*) set -- "$@" --document-private-items ;;
*) exit ;; # a test
esac
# rustdoc takes rustc's options but for what is made, where, and how.
for word; do
	shift
	case ${skip-} in yes) skip='' && continue ;; esac
	case $word in
	--emit=* | --crate-type=*) ;;
	-C | --out-dir | --crate-type) skip=yes ;;
	*) set -- "$@" "$word" ;;
	esac
done
exec rustdoc "$@" -D warnings --out-dir "${CARGO_TARGET_DIR:-target}/doc"
