"""Runs of stages by the common options; errors become one line and an exit code."""

from __future__ import annotations

import json
import os
import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from typing import TYPE_CHECKING

from typer import BadParameter, Exit

from kinmo.cli.console import observer
from kinmo.cli.options import CommonOptions
from kinmo.core.errors import KinmoError
from kinmo.core.wording import duration

if TYPE_CHECKING:
    from kinmo.dataset.stage import Outcome, Plan, Stage

FAILED, INTERRUPTED = 1, 130


def execute(options: CommonOptions, *stages: Stage) -> None:
    """Run stages one after the other and print their results; with --dry-run print their plans.

    Raises:
        Exit: with code 1, if something that the user asked for failed.
    """
    if options.dry_run:
        _print_plans([stage.plan() for stage in stages], as_json=options.json)
        return
    outcomes = []
    with observer(options.quiet) as shown:
        for stage in stages:
            outcomes.append(stage.run(shown))
    _print_outcomes(outcomes, options)
    if any(outcome.failed for outcome in outcomes):
        raise Exit(FAILED)


def _print_plans(plans: list[Plan], as_json: bool) -> None:
    if as_json:
        print(json.dumps([asdict(plan) for plan in plans], indent=1))
        return
    steps = [step for plan in plans for step in plan.steps]
    impossible = [line for plan in plans for line in plan.impossible]
    if not steps:
        steps = ["nothing: everything that is possible is up to date" if impossible else "nothing: everything is up to date"]
    for line in steps + impossible:
        print(line)
    seconds = sum(plan.seconds for plan in plans)
    if seconds:
        print(f"about {duration(seconds)}")


def _print_outcomes(outcomes: list[Outcome], options: CommonOptions) -> None:
    if options.json:
        print(json.dumps(outcomes[-1].data if len(outcomes) == 1 else [o.data for o in outcomes], indent=1))
        return
    for outcome in outcomes:
        if outcome.text and not options.quiet:
            print(outcome.text)
    print(outcomes[-1].path)


@contextmanager
def one_line_errors() -> Iterator[None]:
    """Turn errors into one line on stderr and an exit code; with KINMO_DEBUG=1 into tracebacks."""
    if os.environ.get("KINMO_DEBUG"):
        yield
        return
    _end_as_by_ctrl_c()
    try:
        yield
        sys.stdout.flush()
    except (Exit, BadParameter):
        raise
    except KinmoError as error:
        print(f"kinmo: {error}", file=sys.stderr)
        raise Exit(FAILED) from None
    except KeyboardInterrupt:
        print("kinmo: interrupted; the same command continues from here", file=sys.stderr)
        raise Exit(INTERRUPTED) from None
    except BrokenPipeError:
        # The reader of the output is gone: nothing more can be written, not even by Python's final flush.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise Exit(FAILED) from None
    except (OSError, MemoryError) as error:
        print(f"kinmo: {_sentence(error)}", file=sys.stderr)
        raise Exit(FAILED) from None
    except Exception as error:
        print(f"kinmo: internal error: {type(error).__name__}: {_sentence(error)} (KINMO_DEBUG=1 shows where)", file=sys.stderr)
        raise Exit(FAILED) from None


def _end_as_by_ctrl_c() -> None:
    """Let SIGTERM, which schedulers send, do what Ctrl-C does."""
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, signal.default_int_handler)


def _sentence(error: BaseException) -> str:
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return " ".join(str(error).split()) or type(error).__name__
