"""Figures that the publication prints, in degC; its times have no unit. None: not printed."""

FULLY_CONNECTED = "ed"
SHAPES = ((2, 2), (3, 2), (3, 4), (6, 4))  # sequence length in cycles, layers
SERIES = tuple(f"{kind}-{length}-{layers}" for kind in ("lstm", "transformer") for length, layers in SHAPES)

# Method comparison (its figure 7), energy study (figure 8) and Table VII; method -> figure -> value.
CONTROL = {
    "expert": {"dae_degc": 1.0},  # "above 1"
    "pid-spec": {"dae_degc": 0.35, "cdh_degch": 342.5},
    "osln": {"dae_degc": 0.17189, "darv_degc": 0.49868, "cdh_degch": 371.8},
    "ddqn": {"dae_degc": 0.47, "darv_degc": 0.66, "cdh_degch": 325.1},
    "ed": {"dae_degc": 0.03222, "darv_degc": 0.37255, "decision": 0.012, "cdh_degch": 335.9},
    "lstm-2-2": {"dae_degc": 0.6182, "darv_degc": 0.2389, "decision": 0.028},
    "lstm-3-2": {"dae_degc": 0.8349, "darv_degc": 0.2453, "decision": 0.034},
    "lstm-3-4": {"dae_degc": 1.1604, "darv_degc": 0.1630, "decision": 0.052},
    "lstm-6-4": {"dae_degc": 0.9492, "darv_degc": 0.2893, "decision": 0.092},
    "transformer-2-2": {"dae_degc": 1.0243, "darv_degc": 0.3612, "decision": 0.108},
    "transformer-3-2": {"dae_degc": 0.8984, "darv_degc": 0.3362, "decision": 0.136},
    "transformer-3-4": {"dae_degc": 0.9378, "darv_degc": 0.3641, "decision": 0.258},
    "transformer-6-4": {"dae_degc": 0.6069, "darv_degc": 0.4039, "decision": 0.621},
}

# Tables III and VI; (room, season) -> method -> error.
TRANSFER = {
    ("701", "summer"): {"fatdm-head": 0.451, "fatdm-tail": 0.517, "daf": 0.598, "none": 0.451, "static": 0.215,
                        "dynamic": 0.078},
    ("701", "winter"): {"fatdm-head": 0.952, "fatdm-tail": 0.962, "daf": 0.605, "none": 0.359, "static": 0.396,
                        "dynamic": 0.202},
    ("702", "summer"): {"fatdm-head": 0.570, "fatdm-tail": 0.488, "daf": 0.545, "none": 0.259, "static": 0.204,
                        "dynamic": 0.056},
    ("702", "winter"): {"fatdm-head": 0.716, "fatdm-tail": 0.622, "daf": 0.663, "none": 0.379, "static": 0.346,
                        "dynamic": 0.298},
}
