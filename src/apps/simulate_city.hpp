// SPDX-FileCopyrightText: 2026 The cloud_colorizer authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace cloud_colorizer {

/// `simulate city ...`; returns the exit code.
int runSimulateCity(int argc, char** argv);

}  // namespace cloud_colorizer
