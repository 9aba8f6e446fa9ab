// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause

/// The commands of `evaluate`; each takes its own arguments (argv[0] is the command) and returns the exit code.
#pragma once

namespace cloud_colorizer {

int runTables(int argc, char** argv);
int runAblations(int argc, char** argv);
int runHeldout(int argc, char** argv);
int runAppearance(int argc, char** argv);
int runScore(int argc, char** argv);
int runVisibility(int argc, char** argv);
int runVisible(int argc, char** argv);
int runCity(int argc, char** argv);

}  // namespace cloud_colorizer
