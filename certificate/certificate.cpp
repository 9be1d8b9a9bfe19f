// SPDX-License-Identifier: Apache-2.0

#include "certificate/certificate.h"

#include <fmt/format.h>

#include <algorithm>
#include <pugixml.hpp>
#include <sstream>
#include <utility>

namespace plumb {
namespace {

bool is_bad(const Answer& answer) {
  return answer.mark == Mark::wrong || answer.mark == Mark::failed;
}

bool is_open(const Answer& answer) {
  return answer.mark == Mark::noisy && answer.group != stress_group;
}

}  // namespace

const char* to_string(Mark mark) {
  constexpr const char* names[] = {"right", "wrong", "too noisy to tell", "can't", "failed"};
  return names[size_t(mark)];
}

std::string finding(const Answer& answer) {
  return answer.text + (answer.worst ? "; most clearly " + answer.worst->text : "");
}

bool Certificate::is_passed() const { return exit_code() == 0; }

int Certificate::exit_code() const {
  if (std::ranges::any_of(answers, is_bad)) return 1;
  const bool is_any_right =
      std::ranges::any_of(answers, [](const Answer& a) { return a.mark == Mark::right; });
  return std::ranges::any_of(answers, is_open) || !is_any_right || !is_complete ? 3 : 0;
}

std::string Certificate::summary() const {
  const std::string grade = fmt::format("Plumbline certificate {}{} at {:g} %", certificate_version,
                                        is_quick ? " (quick)" : "", 100.0 * tolerance);
  if (is_passed()) return fmt::format("{} passes {}.", renderer, grade);
  const auto first = std::ranges::find_if(answers, is_bad);
  if (first != answers.end()) {
    return fmt::format("{} does not pass {}. Start with '{}': {}.", renderer, grade, first->name,
                       finding(*first));
  }
  return fmt::format("{}: {} is open, {}.", renderer, grade,
                     is_complete ? "some pictures are too noisy to tell" : "it was interrupted");
}

std::string Certificate::advice() const {
  const auto is_far_noisier = [](const Answer& answer) {
    return answer.mark == Mark::noisy && answer.noise_ratio >= many_times;
  };
  const auto count = std::ranges::count_if(answers, is_far_noisier);
  if (count == 0) return "";
  const auto most = std::ranges::max_element(answers, {}, &Answer::noise_ratio);
  return fmt::format(
      "{} {} too noisy to tell, with up to {:.0f} times the variance of Plumbline's picture of as "
      "many samples. Paths that meet lamps by chance alone are as noisy as that: sampling lamps "
      "directly at each bounce (next event estimation), weighted by multiple importance sampling "
      "(MIS), makes noise fall by far.",
      count, count == 1 ? "answer is" : "answers are", most->noise_ratio);
}

nlohmann::ordered_json to_json(const Certificate& certificate) {
  nlohmann::ordered_json json{
      {"certificate", certificate_version},  {"renderer", certificate.renderer},
      {"version", certificate.version},      {"host", certificate.host},
      {"tolerance", certificate.tolerance},  {"quick", certificate.is_quick},
      {"complete", certificate.is_complete}, {"passed", certificate.is_passed()},
      {"summary", certificate.summary()},    {"advice", certificate.advice()},
      {"noise", certificate.noise}};
  json["answers"] = nlohmann::ordered_json::array();
  for (const Answer& answer : certificate.answers) {
    json["answers"].push_back({{"name", answer.name},
                               {"group", answer.group},
                               {"mark", to_string(answer.mark)},
                               {"text", answer.text},
                               {"bias", answer.bias},
                               {"error", answer.error},
                               {"samplesPerPixel", answer.samples_per_pixel},
                               {"seconds", answer.seconds}});
    if (!answer.worst) continue;
    const Place& place = *answer.worst;
    const Window& w = place.window;
    nlohmann::ordered_json worst{{"window", {w.x, w.y, w.width, w.height}}};
    if (!place.region.empty()) worst = {{"region", place.region}};
    worst.update({{"channel", place.channel}, {"bias", place.bias}, {"error", place.error}});
    json["answers"].back()["worst"] = std::move(worst);
  }
  json["paces"] = nlohmann::ordered_json::array();
  for (const Pace& pace : certificate.paces) {
    json["paces"].push_back({{"name", pace.name},
                             {"secondsToOnePercent", pace.seconds_to_one_percent},
                             {"right", pace.is_right}});
  }
  return json;
}

std::string to_junit(const Certificate& certificate) {
  pugi::xml_document document;
  pugi::xml_node suite = document.append_child("testsuite");
  suite.append_attribute("name") = ("plumb certify " + certificate.renderer).c_str();
  suite.append_attribute("tests") = certificate.answers.size();
  for (const Answer& answer : certificate.answers) {
    pugi::xml_node test = suite.append_child("testcase");
    test.append_attribute("classname") = answer.group.c_str();
    test.append_attribute("name") = answer.name.c_str();
    test.append_attribute("time") = answer.seconds;
    if (answer.mark == Mark::right) continue;
    const char* kind = answer.mark == Mark::wrong    ? "failure"
                       : answer.mark == Mark::failed ? "error"
                                                     : "skipped";
    pugi::xml_node failure = test.append_child(kind);
    failure.append_attribute("message") =
        fmt::format("{}: {}", to_string(answer.mark), finding(answer)).c_str();
  }
  std::ostringstream stream;
  document.save(stream, "  ");
  return stream.str();
}

}  // namespace plumb
