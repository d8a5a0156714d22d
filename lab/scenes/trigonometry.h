// SPDX-License-Identifier: MIT
//
// Sine and cosine without libm, which differs between machines: only addition, multiplication and
// division, so scenes have the same bytes everywhere. Errors stay below 1e-15 for angles below a
// thousand turns.
#pragma once

/// `radians`: an angle in radians.
double sine(double radians);
double cosine(double radians);

/// `turns`: a fraction of a full turn; 0.25 is a right angle. Whole quarters are exact (0, 1, -1).
double turn_sine(double turns);
double turn_cosine(double turns);
