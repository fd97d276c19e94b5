"""The node `grasp_sequencer`: services that run a strategy, its phases and result on topics."""

from __future__ import annotations

import functools
import sys
import threading
import time
from collections.abc import Callable, Collection
from typing import Any, TypeVar

from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.clock import Clock, ClockType, ROSClock
from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future
from std_msgs.msg import String
from std_srvs.srv import Trigger

from grasp_strategies.judging.failure import ABORTED
from grasp_strategies.judging.judge import GraspResult
from grasp_strategies.ros.clock_watch import ClockWatch
from grasp_strategies.ros.gripper_action import CALLERS, GripperAction, opening
from grasp_strategies.ros.interface import HELP
from grasp_strategies.ros.parameters import (
    GRASP_SERVICES,
    LOWER_AND_RELEASE,
    PARAMETERS,
    PREPARE_TIME_OUT,
    SHIPPED_STRATEGIES,
    STRATEGY_PREFIX,
)
from grasp_strategies.ros.topic_scene import TopicScene
from grasp_strategies.scene import SceneError, hand_body_names
from grasp_strategies.sequencer import PHASE_FAILED, VENT_ACTION, Sequencer, abort_scene
from grasp_strategies.strategy import Strategy, load_strategy
from softhand_model.hand.hand import load_hand
from softhand_ros.diagnostics import REPORT_PERIOD, Diagnostics, Report
from softhand_ros.parameters import declare, follow_simulated_time
from softhand_ros.run_node import run_node
from softhand_ros.services import ANSWER_PERIOD, MANY_CALLS, OneAtATime
from softhand_ros.single import ALLOW_SECOND, Single
from softhand_ros.topics import clock_conflict, latched, slow_clock

IDLE_PHASE, HOLDING_PHASE = "idle", "holding what was grasped"
OWN_PHASE_TOPIC = "grasp/phase"
UNEXPECTED_END = "ended by an error; see the log"
LATCHED = latched(1)
CLOCK_PERIOD = 0.1  # [s] of wall time between two looks at /clock for stamps and watches
HOLD_PERIOD = 0.2  # [s] of wall time after which what is held is commanded again
Result = TypeVar("Result")


class Background:
    """Runs work in threads and can wait for all of it."""

    def __init__(self) -> None:
        self._threads: list[threading.Thread] = []

    def start(
        self, work: Callable[[], Result], tell: Callable[[Result], None], on_error: Result
    ) -> None:
        """Start `work` in a thread; `tell` is called in that thread with the result, or with
        `on_error`.

        An exception of `work` is not swallowed: the interpreter prints it, and `tell` gets
        `on_error`.
        """

        def run() -> None:
            """Do the work, then call `tell`."""
            result = on_error
            try:
                result = work()
            finally:
                tell(result)

        self._threads = [thread for thread in self._threads if thread.is_alive()]
        self._threads.append(threading.Thread(target=run, name="strategy"))
        self._threads[-1].start()

    def join(self) -> None:
        """Wait until all work has ended."""
        for thread in self._threads:
            thread.join()


class Run:
    """One running strategy: its phase, its abort flag, and `ended`, a future of its result.

    `service` is the service that was called, `called` the monotonic wall time of the call [s],
    `wanted` the options that the call asks for, `phases` the number of phases with these options,
    `begun` the number of phases that have begun. `tell` is called with the run at each phase.
    """

    def __init__(
        self,
        strategy: Strategy,
        service: str,
        wanted: Collection[str] = (),
        tell: Callable[[Run], None] = lambda run: None,
    ) -> None:
        self.strategy, self.service, self.tell = strategy, service, tell
        self.options = strategy.options.intersection(wanted)
        options = {None, *self.options}
        self.phases = sum(phase.option in options for phase in strategy.phases)
        self.begun = 0
        self.called = time.monotonic()
        self.caller_seen = False  # discovery may find a client later than its call comes
        self.phase = "waiting for simulator and driver"
        self.waits_for = ""  # what is missing before the first phase
        self.abort = threading.Event()
        self.ended: Future = Future()


class SequencerNode(Node):
    """Offers the services grasp/push, grasp/surface_constrained, grasp/edge, grasp/slide_to_wall,
    grasp/feix and grasp/abort.

    A grasp service answers when its strategy has ended. The strategy runs in a thread of its own,
    so that aborts, parameters and further grasp calls are answered meanwhile.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__("grasp_sequencer", **options)
        declare(self, PARAMETERS)
        self._single = Single(self, "sequencer", OWN_PHASE_TOPIC)
        follow_simulated_time(self)
        slow_clock(self, CLOCK_PERIOD)
        self._hand = load_hand(self.get_parameter("hand").value)
        hand_bodies = hand_body_names(chain.name for chain in self._hand.chains)
        self._single.claim(self.get_parameter(ALLOW_SECOND.name).value)
        self._scene = TopicScene(self, hand_bodies)
        self._holding = False
        self._run: Run | None = None
        self._last_result: GraspResult | None = None
        self._background = Background()
        self._idle_abort: Future | None = None
        self._next_answer: dict[str, float] = {}  # monotonic wall time by service [s]
        self._phase_topic = self.create_publisher(String, OWN_PHASE_TOPIC, LATCHED)
        name, hand = self.get_name(), self._hand.name
        self._result_topic = Diagnostics(self, name, hand, "grasp/result", LATCHED)
        self._diagnostics = Diagnostics(self, name, hand)
        self._create_services()
        self._clock_watch = ClockWatch()
        # on steady time: it must go on when simulated time stands still
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(REPORT_PERIOD, self._publish_diagnostics, clock=steady)
        self.create_timer(HOLD_PERIOD, self._hold, clock=steady)
        self._phase_topic.publish(String(data=IDLE_PHASE))
        self.get_logger().info(f"ready: {self._hand.name}")

    def _create_services(self) -> None:
        OneAtATime(self)  # those of ROS itself
        # reentrant: an answer that is pending must not block the refusal of the next call
        group = ReentrantCallbackGroup()
        serves = {name: functools.partial(self._serve_grasp, name) for name in GRASP_SERVICES}
        for name, serve in (serves | {"abort": self._serve_abort}).items():
            self.create_service(
                Trigger, f"grasp/{name}", serve, qos_profile=MANY_CALLS, callback_group=group
            )
        GripperAction(
            self, self._busy, self._start_gripper, self._interrupt, self._scene.greatest_pressure
        )

    # ------------------------------------------------------------ services
    async def _serve_grasp(
        self, service: str, request: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        try:
            run = self._start(service)
        except ValueError as error:
            self.get_logger().warning(
                f"grasp/{service} refused: {error}", throttle_duration_sec=1.0
            )
            response.success, response.message = False, str(error)
            await self._turn_to_answer(service)
            return response
        result: GraspResult = await run.ended
        response.success = result.gripped and result.completed
        response.message = f"{result.outcome}: {result.reason}"
        return response

    def _start(self, service: str) -> Run:
        """Begin a strategy; raises ValueError with the reason why not."""
        lower = self.get_parameter(LOWER_AND_RELEASE).value
        wanted = {LOWER_AND_RELEASE} if lower else ()
        return self._begin_run(Run(self._strategy_of(service), f"grasp/{service}", wanted))

    def _start_gripper(self, to_open: bool, tell: Callable[[Run], None]) -> Run:
        """Begin to open, or to close by the strategy of a service; errors as `_start`."""
        if to_open:
            channels = self._scene.channels or self._hand.channels  # as the driver told last
            strategy = opening(self._hand.name, channels)
        else:
            strategy = self._strategy_of(self.get_parameter("gripper_strategy").value)
        return self._begin_run(Run(strategy, CALLERS, tell=tell))

    def _busy(self) -> str:
        """Why no strategy can begin now; empty when one can."""
        if (other := self._run) is None:
            return ""
        return f"{other.strategy.name} is running (phase {other.phase}); grasp/abort ends it"

    def _begin_run(self, run: Run) -> Run:
        if busy := self._busy():
            raise ValueError(busy)
        self._run = run
        self._scene.take_air()
        self._scene.resume()
        self._begin(lambda: self._work(run), run.ended, GraspResult.not_begun(UNEXPECTED_END))
        return run

    def _strategy_of(self, service: str) -> Strategy:
        """What a service runs: what its parameter says, else what is shipped for the hand."""
        name = self.get_parameter(STRATEGY_PREFIX + service).value
        candidates = [
            load_strategy(one) for one in ([name] if name else SHIPPED_STRATEGIES[service])
        ]
        for strategy in candidates:
            if load_hand(strategy.hand).name == self._hand.name:
                return strategy
        got = ", ".join(f"{strategy.name} for {strategy.hand}" for strategy in candidates)
        raise ValueError(
            f"grasp/{service}: expected a strategy for the hand {self._hand.name}, got {got}; "
            f"parameter {STRATEGY_PREFIX}{service} takes another"
        )

    async def _serve_abort(
        self, request: Trigger.Request, response: Trigger.Response
    ) -> Trigger.Response:
        if (run := self._run) is None:
            response.success, response.message = await self._abort_idle()
        else:
            self._interrupt(run)
            result: GraspResult = await run.ended
            response.success, response.message = result.safe, result.reason
            if result.cause != ABORTED:  # it ended by itself before it noticed the abort
                response.success, done = await self._abort_idle()
                response.message = f"{result.reason}; {done}"
        await self._turn_to_answer("abort")
        return response

    async def _abort_idle(self) -> tuple[bool, str]:
        """Vent without a strategy; calls that come meanwhile share the one vent."""
        action = self.get_parameter("abort_action").value
        if action != VENT_ACTION:
            return True, "no strategy is running; nothing moves"
        if self._idle_abort is None or self._idle_abort.done():
            self._idle_abort = Future()
            vent = functools.partial(abort_scene, self._scene, action)
            self._begin(vent, self._idle_abort, (UNEXPECTED_END, False))
        reason, safe = await self._idle_abort
        until = "; commands are taken again after pneumaticbox/reset" if safe else ""
        return safe, f"no strategy is running; {reason}{until}"

    async def _turn_to_answer(self, service: str) -> None:
        """Limit answers of a service to one per ANSWER_PERIOD; the call itself takes effect at
        once.
        """
        now = time.monotonic()
        due = max(now, self._next_answer.get(service, now))
        self._next_answer[service] = due + ANSWER_PERIOD
        if due > now:
            waited: Future = Future()
            self._begin(functools.partial(time.sleep, due - now), waited, None)
            await waited

    def _interrupt(self, run: Run) -> None:
        run.abort.set()
        self._scene.interrupt()

    def _begin(self, work: Any, ended: Future, on_error: Any) -> None:
        """Begin work that blocks in a thread; `ended` gives what it returns."""

        def tell(result: Any) -> None:
            ended.set_result(result)
            if self.executor is not None:
                self.executor.wake()  # it sleeps until a message comes; the answer is due now

        self._background.start(work, tell, on_error)

    # ------------------------------------------------------------ the strategy's thread
    def _work(self, run: Run) -> GraspResult:
        result = GraspResult.not_begun(UNEXPECTED_END)
        try:
            result = self._run_strategy(run)
        finally:
            self._scene.release()
            self._last_result = result
            self._publish_result(run.strategy, result)
            self._run = None
        return result

    def _run_strategy(self, run: Run) -> GraspResult:
        action = self.get_parameter("abort_action").value
        try:
            time_out = self.get_parameter("connect_time_out").value
            self._scene.connect(time_out, functools.partial(self._wait_for, run))
            if run.strategy.holds_object_out:
                self._scene.check_object(run.strategy.objects)
            self._refuse_late(run)
            sequencer = Sequencer(
                self._scene,
                run.strategy,
                options=run.options,
                control_step=self.get_parameter("control_step").value,
                on_phase=functools.partial(self._enter_phase, run),
                abort=run.abort,
                abort_action=action,
            )
        except (SceneError, ValueError) as error:
            self._enter_phase(run, PHASE_FAILED)
            return self._not_begun(run, str(error), action)
        return sequencer.run()

    def _not_begun(self, run: Run, reason: str, action: str) -> GraspResult:
        """Result when simulator or driver were not there, or an abort came before they were."""
        result = GraspResult.not_begun(reason)
        if action != VENT_ACTION or not run.abort.is_set():
            return result
        done, safe = abort_scene(self._scene, action)
        return result.stopped(f"{reason}; {done}", safe, cause=ABORTED)

    def _refuse_late(self, run: Run, what: str = "the first phase") -> None:
        """Raise SceneError when the caller can no longer expect the hand to move: too late, or the
        caller has gone.
        """
        limit = self.get_parameter(PREPARE_TIME_OUT).value
        if time.monotonic() - run.called > limit:
            raise SceneError(f"after {limit:g} s of waiting ({PREPARE_TIME_OUT}): {what}")
        if self.count_clients(run.service):
            run.caller_seen = True
        elif run.caller_seen:
            raise SceneError(f"the caller of {run.service} has gone while waiting: {what}")

    def _wait_for(self, run: Run, what: str) -> None:
        self._refuse_late(run, what)
        if run.waits_for != what:
            run.waits_for = what
            self.get_logger().info(f"waiting: {what}", throttle_duration_sec=1.0)

    def _hold(self) -> None:
        if self._run is None:
            self._holding = self._scene.go_on_holding()

    def _enter_phase(self, run: Run, phase: str) -> None:
        run.phase, run.waits_for = phase, ""
        self._phase_topic.publish(String(data=phase))
        run.begun += 1
        run.tell(run)
        self.get_logger().info(f"{run.strategy.name}: {phase}")

    def _publish_result(self, strategy: Strategy, result: GraspResult) -> None:
        warnings = () if result.gripped else (result.outcome,)
        report = Report(strategy.name, result.outcome, warnings, result.summary())
        self._result_topic.publish([report])
        self.get_logger().info(f"{strategy.name}: {result.outcome}: {result.reason}")

    # ------------------------------------------------------------ diagnostics
    def _publish_diagnostics(self) -> None:
        run, last, feeds = self._run, self._last_result, self._scene.feeds
        refusals = [f"refused {f.topic}: {f.last_refusal}" for f in feeds if f.last_refusal]
        idle = HOLDING_PHASE if self._holding else IDLE_PHASE
        phase = f"{run.strategy.name}: {run.phase}" if run else idle
        values = {"phase": phase, "last_result": f"{last.outcome}: {last.reason}" if last else ""}
        values |= {f"refused {feed.topic}": str(feed.refused) for feed in feeds}
        waiting = f"waiting: {run.waits_for}" if run and run.waits_for else ""
        warnings = (waiting, self._single.warning(), self._clock_warning(), *refusals)
        self._diagnostics.publish([Report("sequencer", phase, warnings, values)])

    def _clock_warning(self) -> str:
        if conflict := clock_conflict(self):
            return conflict
        clock = self.get_clock()
        if isinstance(clock, ROSClock) and clock.ros_time_is_active:
            return self._clock_watch.warning(clock.now().nanoseconds, time.monotonic())
        if self.count_publishers("/clock"):
            return "/clock is published but use_sim_time is false: phases follow wall time"
        return ""

    # ------------------------------------------------------------ end
    def end_strategy(self) -> None:
        """Abort a running strategy and wait for its thread; the executor must still be spinning."""
        if (run := self._run) is not None:
            self._interrupt(run)
        self._background.join()

    def close(self) -> None:
        """Destroy the node."""
        self.destroy_node()


def run(node: SequencerNode, stop: threading.Event) -> None:
    """Serve until `stop`; then abort a running strategy while the executor can still call the vent
    service.
    """
    executor = SingleThreadedExecutor(context=node.context)
    executor.add_node(node)

    def spin() -> None:
        """Serve callbacks until ROS is shut down; then all ends."""
        try:
            executor.spin()
        except ExternalShutdownException:
            pass
        finally:
            stop.set()

    spinning = threading.Thread(target=spin, name="executor")
    spinning.start()
    try:
        stop.wait()
    finally:
        node.end_strategy()
        executor.shutdown()
        spinning.join()


def main(args: list[str] | None = None) -> int:
    """Run the node; returns the exit status of `run_node`."""
    return run_node("sequencer", SequencerNode, run, usage=HELP, args=args)


if __name__ == "__main__":
    sys.exit(main())
