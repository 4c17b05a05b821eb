"""The neural peers of the published comparison on simulated rooms (docs/peers.md). tools/gym/method_peers runs them."""
