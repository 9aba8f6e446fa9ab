# SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
# SPDX-License-Identifier: BSD-3-Clause
"""What spread_dask and spread_slurm share: their arguments, and the commands of each stage."""
import argparse
import json
import os
import subprocess
import sys


class Spread:
    """The colouring of one recording as commands that machines with a common disk may run."""

    def __init__(self, description, add_options):
        parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
        parser.add_argument("recording", help="on a disk that all machines see at this path")
        parser.add_argument("arguments", nargs="*", metavar="name=value", help="parameters of colorize")
        parser.add_argument("--output", required=True, help="the coloured map, .ply, .pcd or .las")
        parser.add_argument("--colorize", metavar="PATH", help="the program, at this path on all machines")
        add_options(parser)
        self.options = parser.parse_intermixed_args()
        wrong = [argument for argument in self.options.arguments if "=" not in argument]
        if wrong:
            parser.error(f"unexpected argument {wrong[0]}; parameters are given as name=value")
        recording = os.path.abspath(self.options.recording)
        self.command = [self.options.colorize or find_colorize(), recording] + self.options.arguments
        planned = subprocess.run(self.command + ["--plan"], stdout=subprocess.PIPE, text=True)
        if planned.returncode != 0:
            sys.exit(planned.returncode)
        self.stages = json.loads(planned.stdout)["stages"]

    def has_parameter(self, name):
        return any(argument.startswith(name + "=") for argument in self.options.arguments)

    def of_stage(self, stage):
        """The command of a stage, without its part."""
        command = self.command + ["--stage", stage["name"]]
        if stage["name"] == "merge":
            command += ["--output", os.path.abspath(self.options.output)]
        return command


def find_colorize():
    """As rosrun finds it."""
    found = subprocess.run(["catkin_find", "--first-only", "--libexec", "cloud_colorizer", "colorize"],
                           stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
    path = found.stdout.strip()
    if not path:
        sys.exit("error: no program colorize is found; source devel/setup.bash, or give --colorize PATH")
    return path
