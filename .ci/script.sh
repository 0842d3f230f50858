#!/usr/bin/env bash
# Builds the scripts of reports' pages from their sources and the pinned packages, and compares them with the
# committed ones. Run it in the project's folder.
set -euo pipefail
assets=fesloop/show/report/assets
if ! command -v npm >/dev/null; then
    echo "npm is not installed: the page's scripts cannot be built anew (Debian: apt-get install npm)" >&2
    exit 1
fi
committed=$(mktemp -d)
trap 'rm -rf "$committed"' EXIT
cp -R "$assets/." "$committed"
(cd fesloop/show/report/web && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error && npm run --silent build)
diff -rq "$committed" "$assets" || {
    echo "the committed scripts are not what their sources make: npm ci && npm run build in fesloop/show/report/web" >&2
    exit 1
}
