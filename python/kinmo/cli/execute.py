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
    from kinmo.dataset.stage import Plan, Stage

FAILED, INTERRUPTED = 1, 130


def execute(options: CommonOptions, stage: Stage) -> None:
    """Run a stage and print its result; with --dry-run print its plan.

    Raises:
        Exit: with code 1, if something that the user asked for failed, or is impossible.
    """
    if options.dry_run:
        plan = stage.plan()
        _print_plan(plan, options.json)
        if plan.failed:
            raise Exit(FAILED)
        return
    with observer(options.quiet) as shown:
        outcome = stage.run(shown)
    if options.json:
        print(json.dumps(outcome.data, indent=1))
    else:
        if outcome.text and not options.quiet:
            print(outcome.text)
        if outcome.path is not None:
            print(outcome.path)
    if outcome.failed:
        raise Exit(FAILED)


def _print_plan(plan: Plan, as_json: bool) -> None:
    if as_json:
        print(json.dumps([asdict(plan)], indent=1))
        return
    steps = plan.steps
    if not steps and not plan.failed:
        steps = (f"nothing: everything{' that is possible' if plan.impossible else ''} is up to date",)
    print(*steps, *plan.impossible, sep="\n")
    if plan.seconds:
        print(f"about {duration(plan.seconds)}")


@contextmanager
def one_line_errors() -> Iterator[None]:
    """Turn errors into one line on stderr and an exit code; with KINMO_DEBUG=1 into tracebacks."""
    if os.environ.get("KINMO_DEBUG"):
        yield
        return
    if threading.current_thread() is threading.main_thread():  # SIGTERM, which schedulers send, does what Ctrl-C does
        signal.signal(signal.SIGTERM, signal.default_int_handler)
    code = FAILED
    try:
        yield
        sys.stdout.flush()
        return
    except (Exit, BadParameter):
        raise
    except KeyboardInterrupt:
        problem, code = "interrupted; the same command continues from here", INTERRUPTED
    except BrokenPipeError:
        # The reader of the output is gone: nothing more can be written, not even by Python's final flush.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        raise Exit(FAILED) from None
    except KinmoError as error:
        problem = str(error)
    except (OSError, MemoryError) as error:
        problem = _sentence(error)
    except Exception as error:
        problem = f"internal error: {type(error).__name__}: {_sentence(error)} (KINMO_DEBUG=1 shows where)"
    print(f"kinmo: {problem}", file=sys.stderr)
    raise Exit(code)


def _sentence(error: BaseException) -> str:
    if isinstance(error, OSError) and error.strerror:
        return f"{error.filename}: {error.strerror}" if error.filename else error.strerror
    return " ".join(str(error).split()) or type(error).__name__
