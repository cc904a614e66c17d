"""The ROS node of the simulation."""

from __future__ import annotations

from contextlib import ExitStack

import rclpy
from rclpy.executors import Executor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from shirube_ros.node import node_executor


def simulation_graph(stack: ExitStack, domain: int) -> tuple[Node, Executor]:
    """Create the simulation's node and its executor, both destroyed with the stack."""
    context = rclpy.Context()
    rclpy.init(context=context, domain_id=domain, signal_handler_options=SignalHandlerOptions.NO)
    stack.callback(context.try_shutdown)
    node = Node('scene_simulator', context=context)
    stack.callback(node.destroy_node)
    executor = node_executor(context)
    stack.callback(executor.shutdown)
    executor.add_node(node)
    return node, executor
