// Values as words, the same on the command line and in images. All that parse throw
// std::invalid_argument, which says what the text should have been.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "renderer/settings.h"

namespace plumb {

std::string to_string(Method method);
std::string to_string(Sampler sampler);
std::string to_string(Precision precision);

Method parse_method(const std::string& text);
Sampler parse_sampler(const std::string& text);
Precision parse_precision(const std::string& text);

// "64:128", the last one left out.
std::string to_string(const SampleRange& samples);
SampleRange parse_samples(const std::string& text);

// "2:5", the last one included; "0:" for all; "2" for one.
std::string to_string(const BounceRange& bounces);
BounceRange parse_bounces(const std::string& text);

int64_t parse_whole(const std::string& text, int64_t least, int64_t most);
double parse_positive(const std::string& text);
double parse_between(const std::string& text, double least, double most);

// "0.01" or "1%".
double parse_fraction(const std::string& text);

// "640x480".
std::pair<int, int> parse_size(const std::string& text);

}  // namespace plumb
