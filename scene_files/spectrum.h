// SPDX-License-Identifier: Apache-2.0

// Spectra as colours, as Mitsuba 3 in its rgb variants takes them from scene files.
#pragma once

#include <utility>
#include <vector>

#include "scene/scene.h"

namespace plumb {

// Pairs of a wavelength in nm, rising, and a value; linear in between, and 0 outside.
using Spectrum = std::vector<std::pair<double, double>>;

// The linear Rec. 709 colour of the spectrum by the CIE's colour matching functions of 1931, such
// that a constant spectrum of 1 has luminance 1. A reflectance is seen under the illuminant D65, so
// that a constant one is grey, and is clamped to what lies between 0 and 1. So is a refractive
// index, which has no such bound. What is negative becomes 0, also of what a lamp emits.
Rgb reflectance_of(const Spectrum& spectrum, double highest = 1.0);
Rgb emission_of(const Spectrum& spectrum);

// Emission that is the same at all wavelengths: reddish compared with D65.
Rgb even_emission(double value);

// Planck's law: radiance of a black body at a temperature in kelvin, in W / (m^2 sr nm).
Spectrum black_body(double temperature);

}  // namespace plumb
