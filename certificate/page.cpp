// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string_view>

#include "certificate/certificate.h"

namespace plumb {
namespace {

constexpr const char* head = R"(<!doctype html>
<html lang="en">
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{0}: certificate</title>
<style>
:root {{ color-scheme: light dark; --line: #8884; --soft: #777; }}
body {{ font: 16px/1.5 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem; }}
table {{ border-collapse: collapse; width: 100%; }}
th, td {{ text-align: left; padding: .3rem .6rem; border-top: 1px solid var(--line);
  vertical-align: top; }}
td.number {{ text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }}
.mark {{ white-space: nowrap; font-weight: 600; }}
.right {{ color: #1a7f37; }} .wrong, .failed {{ color: #cf222e; }} .noisy {{ color: #9a6700; }}
.cannot, .about {{ color: var(--soft); }}
.about {{ font-size: .9em; white-space: pre-line; }}
figure {{ display: inline-block; margin: .5rem 1rem .5rem 0; }}
figure img {{ width: 192px; image-rendering: pixelated; display: block; }}
figcaption {{ font-size: .85em; color: var(--soft); }}
.verdict {{ font-size: 1.2em; border-left: .3rem solid; padding-left: .8rem; }}
</style>
<h1>{0}</h1>
)";

std::string escape(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&': escaped += "&amp;"; break;
      case '<': escaped += "&lt;"; break;
      case '>': escaped += "&gt;"; break;
      case '"': escaped += "&quot;"; break;
      default: escaped += c;
    }
  }
  return escaped;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t triple = 0;
    for (size_t j = i; j < i + 3; ++j) {
      triple = triple << 8 | (j < bytes.size() ? static_cast<unsigned char>(bytes[j]) : 0u);
    }
    for (size_t j = 0; j < 4; ++j) {
      const size_t digit = triple >> (18 - 6 * j) & 63;
      text += i + j > bytes.size() ? '=' : digits[digit];
    }
  }
  return text;
}

// As a PNG that stands in the page.
std::string embed(const Image& image) {
  const auto file = std::filesystem::temp_directory_path() /
                    fmt::format("plumb-{}.png", reinterpret_cast<uintptr_t>(&image));
  write_image(image, file);
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(stream), {});
  std::filesystem::remove(file);
  return "data:image/png;base64," + base64(bytes);
}

const char* style_of(Mark mark) {
  constexpr std::array styles{"right", "wrong", "noisy", "cannot", "failed"};
  return styles[size_t(mark)];
}

std::string row(const Answer& answer) {
  std::string cells = fmt::format(
      "<tr><td>{}<td class=\"mark {}\">{}<td>{}<td class=number>{}<td class=number>{:.1f} s\n",
      escape(answer.name), style_of(answer.mark), to_string(answer.mark), escape(finding(answer)),
      answer.samples_per_pixel == 0 ? "" : std::to_string(answer.samples_per_pixel),
      answer.seconds);
  if (answer.mark != Mark::wrong && answer.mark != Mark::failed) return cells;
  cells += fmt::format("<tr><td colspan=5><div class=about>{}</div>\n", escape(answer.about));
  for (const auto& [caption, image] : answer.pictures) {
    cells +=
        fmt::format("<figure><img alt=\"{0}\" src=\"{1}\"><figcaption>{0}</figcaption></figure>\n",
                    escape(caption), embed(image));
  }
  return cells;
}

std::string table(const std::vector<Answer>& answers) {
  std::string rows, group;
  for (const Answer& answer : answers) {
    if (answer.group != group) {
      group = answer.group;
      rows += fmt::format("<tr><th colspan=5>{}\n", escape(group));
    }
    rows += row(answer);
  }
  return "<table>\n<tr><th>question<th>answer<th>finding<th>samples<th>took\n" + rows +
         "</table>\n";
}

std::string pace_table(const std::vector<Pace>& paces) {
  if (paces.empty()) return "";
  std::string rows;
  for (const Pace& pace : paces) {
    rows += fmt::format("<tr><td>{}<td class=number>{:.3g} s<td>{}\n", escape(pace.name),
                        pace.seconds_to_one_percent, pace.is_right ? "" : "(but biased)");
  }
  return "<h2>Speed</h2>\n<p>Seconds to a relative error of 1 % in the Cornell box of 256 x 256 "
         "pixels, on this machine, by\nvariance times time; start-up counts where the program does "
         "not say what it took.\n<table>\n" +
         rows + "</table>\n";
}

}  // namespace

std::string to_html(const Certificate& certificate) {
  const int code = certificate.exit_code();
  const char* style = code == 0 ? "right" : code == 1 ? "wrong" : "noisy";
  std::string page = fmt::format(head, escape(certificate.renderer));
  page += fmt::format("<p class=\"verdict {}\">{}\n", style, escape(certificate.summary()));
  page += fmt::format(
      "<p>{}{}. A finding is how far the whole picture is off, with half of its 95 % interval; "
      "then which block of\n8 x 8 pixels, by its upper left one, or which region is off most "
      "clearly, in which channel and how far.\n<i>Right</i> means that the picture and each of its "
      "regions are surely within {:g} %, "
      "<i>wrong</i> that something in it surely is not:\nby noise alone this page calls a right "
      "renderer wrong once in a thousand times.\n",
      escape(certificate.version.empty() ? certificate.renderer : certificate.version),
      certificate.host.empty() ? "" : ", " + escape(certificate.host),
      100.0 * certificate.tolerance);
  if (code == 1) {
    page +=
        "<p>The first wrong answer is the place to start. What it looks like is also said by "
        "<code>plumb diagnose\n"
        "PICTURE SCENE</code>, of a picture that the renderer drew of a scene file, such as "
        "<code>cornell/scene.xml</code>.\n";
  }
  if (const std::string advice = certificate.advice(); !advice.empty()) {
    page += fmt::format("<p>{}\n", escape(advice));
  }
  if (!certificate.is_complete) page += "<p>It was interrupted: not all questions were asked.\n";
  page += table(certificate.answers);
  if (!certificate.noise.empty()) {
    page += fmt::format("<h2>Noise</h2>\n<p>{}\n", escape(certificate.noise));
  }
  return page + pace_table(certificate.paces) + "</html>\n";
}

}  // namespace plumb
