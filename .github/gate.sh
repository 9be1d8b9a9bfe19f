#!/bin/sh
# SPDX-License-Identifier: Apache-2.0

# Runs a gate and leaves in a folder what it found: gate.txt, results.xml for JUnit's readers, and
# report.html, one file with all pictures and reports (.png, .md) that the gate has put there. The
# same goes into GitHub's summary, without the pictures. Run as: gate.sh GATE.toml FOLDER
set -u
gate=$1
folder=$2
mkdir -p "$folder"
plumb compare --gate "$gate" --junit "$folder/results.xml" >"$folder/gate.txt" 2>&1
status=$?
cat "$folder/gate.txt"

preformatted() { printf '<pre>'; sed 's/&/\&amp;/g; s/</\&lt;/g' "$1"; printf '</pre>\n'; }

cat >>"${GITHUB_STEP_SUMMARY:-/dev/null}" <<END
### Pictures

\`\`\`
$(cat "$folder/gate.txt")
\`\`\`
END
{
  printf '<!doctype html>\n<html lang="en">\n<meta charset="utf-8">\n<title>%s</title>\n' "$gate"
  printf '<style>:root { color-scheme: light dark } pre { white-space: pre-wrap }\n'
  printf 'img { min-width: 256px; image-rendering: pixelated }</style>\n<h1>Pictures</h1>\n'
  preformatted "$folder/gate.txt"
  for report in "$folder"/*.md; do
    [ -e "$report" ] || continue
    printf '<details><summary>%s</summary>\n' "$(basename "$report" .md)"
    preformatted "$report"
    printf '</details>\n'
    printf '\n' | cat - "$report" >>"${GITHUB_STEP_SUMMARY:-/dev/null}"
  done
  for picture in "$folder"/*.png; do
    [ -e "$picture" ] || continue
    printf '<figure><img alt="" src="data:image/png;base64,%s"><figcaption>%s</figcaption></figure>\n' \
      "$(base64 -w0 "$picture")" "$(basename "$picture" .png)"
  done
} >"$folder/report.html"
exit $status
