// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "cli/diagnosis.h"
#include "cli/film_image.h"
#include "cli/interrupt.h"
#include "cli/names.h"
#include "cli/progress_line.h"
#include "cli/scene_options.h"
#include "compare/maps.h"
#include "compare/markdown.h"

namespace plumb::cli {
namespace {

namespace fs = std::filesystem;

struct Options {
  std::string picture, folder;
  SceneOptions scene;
  double tolerance = 0.01;
};

// What explains less is not claimed: that it is not refuted may be the noise, all the more so if
// that may hide all of some part (within > 1).
constexpr double worth_a_claim = 0.5, worth_a_claim_in_noise = 0.9;

// What is shown of the suspects.
constexpr size_t rows_shown = 8;

// What noise may hide; where that is everything, also what would help. Noise falls with the root of
// the samples.
std::string hidden(double within, double tolerance) {
  if (within <= 1.0) return fmt::format("noise may hide {} somewhere", percent(within));
  const double times = std::pow(within / tolerance, 2.0);
  const double unit = std::pow(10.0, std::floor(std::log10(times)));
  return fmt::format(
      "the picture is too noisy to tell anything of some parts: it takes about {:.0f} times the "
      "samples for {} everywhere",
      std::ceil(times / unit) * unit, percent(tolerance));
}

std::string sentence(const Diagnosis& d, double tolerance) {
  if (!d.healthy.is_refuted) {
    const std::string within = percent(d.healthy.within);
    if (d.healthy.within <= tolerance) {
      return fmt::format("same as the reference, to {} everywhere: nothing to diagnose", within);
    }
    return fmt::format(
        "inconclusive: no difference from the reference is seen, but {}: nothing to diagnose",
        hidden(d.healthy.within, tolerance));
  }
  const std::string different = "different from the reference: " + d.healthy.rest + "\n";
  if (d.suspects.empty()) return different + "none of these";
  const Suspect& best = d.suspects.front();
  const std::string within = percent(best.agreement.within);
  const double enough = best.agreement.within <= 1.0 ? worth_a_claim : worth_a_claim_in_noise;
  if (!best.agreement.is_refuted && best.explained < enough) {
    return fmt::format(
        "{}too noisy to tell what: {} comes first, but explains {} of the squared difference",
        different, name_of(best), percent(best.explained));
  }
  if (!best.agreement.is_refuted && best.agreement.within <= tolerance) {
    return fmt::format("{}same as the reference with {}, to {} everywhere", different,
                       name_of(best), within);
  }
  if (!best.agreement.is_refuted) {
    return fmt::format("{}like the reference with {}, but {}", different, name_of(best),
                       hidden(best.agreement.within, tolerance));
  }
  return fmt::format("{}none of these: {} explains {} of the squared difference; the rest is {}",
                     different, name_of(best), percent(best.explained), best.agreement.rest);
}

std::string table_of(const Diagnosis& d) {
  std::vector<TableRow> rows;
  for (const Suspect& s : d.suspects) {
    if (rows.size() == rows_shown) break;
    const double within = s.agreement.within;
    const std::string left = within <= 1.0 ? "nothing, to " + percent(within) : "noise hides it";
    rows.push_back(
        {name_of(s), percent(s.explained), s.agreement.is_refuted ? s.agreement.rest : left});
  }
  return table({"suspect", "explains", "what is left"}, rows);
}

std::string remark(const Diagnosis& d) {
  if (d.shared_noise < much_shared_noise) return "";
  return fmt::format(
      "neighbouring pixels share noise (correlation {:.2f}): it was filtered, or `denoised`\n",
      d.shared_noise);
}

}  // namespace

std::string to_text(const Diagnosis& d, double tolerance) {
  std::string text = fmt::format("{}\n{}{}", sentence(d, tolerance), remark(d), table_of(d));
  if (!d.suspects.empty()) {
    text += '\n';
    for (const Planting& p : d.suspects.front().plantings) {
      text += fmt::format("`{}`: {}\n", fault_name(p.fault), description(p.fault).text);
    }
  }
  if (d.tried > 0) text += fmt::format("\n{} suspects were tried\n", d.tried);
  return text;
}

Verdict verdict_of(const Diagnosis& d, double tolerance) {
  if (d.healthy.is_refuted) return Verdict::different;
  return d.healthy.within <= tolerance ? Verdict::same : Verdict::inconclusive;
}

void warn_of_another_version(const Scene& scene, const Picture& test) {
  const auto& hash = test.image.provenance.scene_hash;
  if (hash && hash != scene.hash) {
    say("the picture says that it is of another version of the scene");
  }
}

namespace {

// The difference, what the likeliest suspect would change, and the rest.
void draw(const Diagnosis& d, Picture& test, const fs::path& folder) {
  fs::create_directories(folder);
  const Film& model = d.suspects.empty() ? d.reference : *d.suspects.front().film;
  Picture reference = to_picture("reference", d.reference);
  Picture suspect = to_picture("reference", model);
  Picture suspected = to_picture("test", model);
  const Window all{0, 0, test.image.width, test.image.height};
  const auto write = [&](Picture& a, Picture& b, const char* name) {
    match(a, b, {"R", "G", "B"}, true);
    write_image(draw_map(MapKind::difference, a, b, all), folder / name);
    fmt::print("wrote {}\n", (folder / name).string());
  };
  write(test, reference, "difference.png");
  write(suspected, reference, "suspect.png");
  write(test, suspect, "rest.png");
}

int run(const Options& options) {
  Picture test = read_picture("test", {options.picture}, "");
  const Scene scene = load_scene(options.scene);
  warn_of_another_version(scene, test);
  listen_for_interrupts();
  std::optional<Diagnosis> found;
  {
    ProgressLine line;
    found = diagnose(
        scene, test, options.tolerance, [&](const std::string& text) { line.show(text); },
        stop_requested);
  }
  if (!found) return 128 + stop_signal;
  fmt::print("{}", to_text(*found, options.tolerance));
  if (!options.folder.empty()) draw(*found, test, options.folder);
  return static_cast<int>(verdict_of(*found, options.tolerance));
}

}  // namespace

void add_diagnose(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<Options>();
  CLI::App& command = *app.add_subcommand("diagnose", "Tell what a wrong picture looks like");
  add_option(command, "PICTURE", "", options->picture,
             "Picture of the scene by any program, linear, in any\nformat OpenImageIO reads")
      ->required();
  add_scene_option(command, options->scene);
  add_option(command, "--tolerance", "T", options->tolerance, parse_fraction,
             "Difference that doesn't matter, as 0.01 or 1%: 'same'\n"
             "is said of what surely differs by less (default: 1%)");
  add_option(command, "-o,--output", "FOLDER", options->folder,
             "Pictures of the difference, of what the likeliest\n"
             "suspect would change, and of the rest");
  command.footer(R"(Examples:
  plumb diagnose mine.exr reference_scenes/cornell/scene.xml
  plumb diagnose mine.exr scene.xml --tolerance 0.5% -o why

The scene is rendered in the picture's size, and again with each of 'plumb
faults', alone and in pairs.

Exit codes: 0 same, nothing to diagnose, 1 different, whatever was found,
2 trouble, 3 inconclusive: no difference seen, but too noisy to say more,
130 interrupted.)");
  command.callback([=, &exit_code] { exit_code = run(*options); });
}

}  // namespace plumb::cli
