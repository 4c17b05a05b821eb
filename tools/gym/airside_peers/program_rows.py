"""Rows of the program itself on the same days: its own method, the published one in C++, and what needs no network."""

import json

from airside_gym.program import run as run_program

from .runs import OF_THE_PROGRAM

EXPERT_DAYS = 5
PRESETS = {"airside-product": "product", "airside-paper": "paper"}  # both without a twin, as the peers
FIGURES = ("dae_degc", "me_degc", "darv_degc", "cdh_degch", "hdh_degch", "daily_dae_degc", "commit")


def figures_of(program, run):
    settings = dict(run.settings)
    words = ["simulate", "--plant", run.plant, "--room", run.room, "--seed", str(run.seed), "--start", settings["from"],
             "--expert-days", str(EXPERT_DAYS), "--days", str(settings["days"]), "--json"]
    if run.method in PRESETS:
        words += ["--preset", PRESETS[run.method], "--transfer"]
    else:
        words += ["--method", run.method]
    told = json.loads(run_program(program, *words))
    return {name: told[name] for name in FIGURES}


def is_of_the_program(run):
    return run.method in OF_THE_PROGRAM
