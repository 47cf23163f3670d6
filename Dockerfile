# The command `stickslip`, without a Rust installation: `docker build -t stickslip .`, then
# `docker run --rm -v "$PWD:/data" stickslip check /data/bench`.
FROM rust:1-slim-trixie AS build
WORKDIR /src
COPY . .
# The image's own toolchain: the one of rust-toolchain.toml would be fetched, with the board's target.
# Without debug information: the program is a fifth of the size.
ENV CARGO_PROFILE_RELEASE_DEBUG=0 CARGO_PROFILE_RELEASE_STRIP=true
RUN rm rust-toolchain.toml && cargo install --locked --root /opt/stickslip --path host/cli

FROM debian:trixie-slim
COPY --from=build /opt/stickslip/bin/stickslip /usr/local/bin/
WORKDIR /data
ENTRYPOINT ["stickslip"]
