"""More slow work than threads, and a stop service that does not wait in the queue."""

from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse

from executors_demo.demo import Demo, ExecutorParameters, period_of, sleep_of
from nodekit import (
    BoolParameter,
    IntParameter,
    MutuallyExclusiveCallbackGroup,
    Node,
    read_once,
    run,
)


class EmergencyStopParameters(ExecutorParameters):
    """Parameters of emergency_stop."""

    threads = IntParameter(2, minimum=1, maximum=100, help="threads of the executor multi")
    jobs = read_once(IntParameter(8, minimum=1, maximum=100, help="number of slow timers"))
    job_period = period_of(1.0, "each job")
    job_sleep = sleep_of(0.5, "each job")
    urgent = read_once(BoolParameter(True, help="whether the stop precedes all waiting calls"))


class EmergencyStop(Demo[EmergencyStopParameters]):
    """Eight jobs of half a second each, every second, on two threads: some jobs always wait.

    The service ``stop`` is in an urgent group, so it is called as soon as a thread is free. With
    ``_urgent:=false`` it waits in the queue behind the jobs.

    :ROS Services:
        - ``stop`` (std_srvs/SetBool): true stops the jobs, false continues them
        - ``~executor`` (std_srvs/Trigger): waiting, running and skipped calls

    :ROS Parameters:
        - private, can be changed at run time: see :class:`EmergencyStopParameters`
    """

    def __init__(self, node: Node) -> None:
        super().__init__(node, EmergencyStopParameters)
        self._is_stopped = False
        for number in range(1, self.settings.jobs + 1):
            job = Job(self, f"job{number}")
            node.create_timer(
                lambda: 1.0 / self.settings.job_period,
                job.work,
                group=MutuallyExclusiveCallbackGroup(),
            )
        urgent = MutuallyExclusiveCallbackGroup(urgent=self.settings.urgent)
        node.create_service("stop", SetBool, self.stop, group=urgent)

    @property
    def is_stopped(self) -> bool:
        """Whether the jobs are stopped."""
        return self._is_stopped

    def stop(self, request: SetBoolRequest) -> SetBoolResponse:
        """Stop or continue the jobs."""
        self._is_stopped = request.data
        text = "stopped" if request.data else "going on"
        self.work("stop", 0.0, text)
        return SetBoolResponse(True, text)


class Job:
    """Slow work in its own group: it runs in parallel with other jobs, but not with itself.

    :param demo: the demo that it belongs to
    :param name: its name
    """

    def __init__(self, demo: EmergencyStop, name: str) -> None:
        self._demo, self._name = demo, name

    def work(self, elapsed: float) -> None:
        """Work for ``~job_sleep``, unless the jobs are stopped."""
        if not self._demo.is_stopped:
            self._demo.work(self._name, self._demo.settings.job_sleep)


def main() -> None:
    """Run the node until it is shut down."""
    run("emergency_stop", EmergencyStop)
