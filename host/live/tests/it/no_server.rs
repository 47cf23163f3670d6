//! Built without the server for Foxglove.

use stickslip_live::foxglove::Server;

#[test]
fn without_the_feature_the_server_refuses_and_says_how_to_get_it() {
    let why = Server::start("127.0.0.1:0").err().expect("refused").to_string();
    assert!(why.contains("feature `foxglove`") && why.contains("cargo install --path host/cli"), "{why}");
}
