"""Command line: `python -m ballrace.fleet COMMAND --machines ROOT --out RESULTS … [-- OPTIONS OF THE COMMAND]`."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import asdict

from . import settings
from .engine import print_progress, run
from .sources import InputError
from .work import COMMANDS


def parser() -> argparse.ArgumentParser:
    """Options of the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m ballrace.fleet",
        description="Run a ballrace command over many machines. Options after -- go to the command.",
        epilog="Example: python -m ballrace.fleet monitor --machines data --model model.bin --out results -- --sample-rate 25600",
    )
    parser.add_argument("command", choices=COMMANDS)
    parser.add_argument("--machines", required=True, help="folder with a subfolder or a partition machine=NAME a machine, or synthetic:COUNT")
    parser.add_argument("--out", required=True, help="folder of the results; the same command goes on where it ended")
    parser.add_argument("--model", help="model of monitor")
    parser.add_argument("--rig", help="rig.toml of diagnose, for machines without one of their own")
    parser.add_argument("--baseline", help="healthy recordings of diagnose, for machines without a folder baseline")
    parser.add_argument("--config", help="sweep.toml of sweep, without the key recordings")
    parser.add_argument("--day", action="append", default=[], dest="days", help="only this partition day=DAY; may be repeated")
    parser.add_argument("--workers", type=int, help="processes on this machine [default: one a core]")
    parser.add_argument("--scheduler", help="address of a Dask scheduler, such as tcp://host:8786")
    parser.add_argument("--program", help="the ballrace program [default: $BALLRACE, then $PATH]")
    parser.add_argument("--batch", type=int, default=settings.BATCH, help="machines of a batch and of a result file [default: %(default)s]")
    parser.add_argument("--timeout", type=float, default=settings.TIMEOUT_S, help="seconds a machine may take [default: %(default)s]")
    parser.add_argument("--retry-errors", action="store_true", help="repeat batches in which a machine had an error")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    return parser


def main(arguments: list[str]) -> int:
    """Run, and return the exit code: 0 done, 2 bad input, 130 interrupted."""
    own, options = arguments, []
    if "--" in arguments:
        cut = arguments.index("--")
        own, options = arguments[:cut], arguments[cut + 1 :]
    given = vars(parser().parse_args(own))
    as_json = given.pop("json")
    given |= {"timeout_s": given.pop("timeout"), "options": tuple(options), "days": tuple(given["days"])}
    try:
        summary = run(given.pop("command"), given.pop("machines"), given.pop("out"), **given, progress=print_progress())
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("\ninterrupted: batches that are done are kept, and the same command goes on", file=sys.stderr)
        return 130
    if as_json:
        print(json.dumps(asdict(summary)))
    else:
        print(f"{summary.machines} machines, {summary.errors} with an error, {summary.before} done before, {summary.seconds:.1f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
