"""Calls of compiled kernels by their address in memory.

A loop that takes the addresses of its kernels is compiled only once. With numba's own way, kernels
as arguments, it would be compiled again for every combination of kernels.
"""

from __future__ import annotations

from typing import Any

from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


def address_of(kernel: Any, arguments: tuple[types.Type, ...]) -> int:
    """Address of a kernel for arguments of these types; compiles it or loads it from the cache.

    Raises numba.core.errors.NumbaError when numba cannot compile the kernel, and TypeError for a
    kernel that returns a value.
    """
    kernel.compile(arguments)
    found = kernel.get_compile_result(types.none(*arguments))
    if found.signature.return_type != types.none:
        raise TypeError(f"expected a function without a result, got {found.signature.return_type}")
    return int(found.library.get_pointer_to_function(found.fndesc.llvm_func_name))


def call_with(arguments: tuple[types.Type, ...]) -> Any:
    """The function `call(address, (argument, ...))` for compiled code. It converts the arguments
    to these types and calls the kernel at an address that `address_of` gave for the same types.
    """
    given = types.Tuple(arguments)

    @intrinsic
    def call(typing_context: Any, address: Any, values: Any) -> Any:
        def generate(context: Any, builder: Any, _signature: Any, parts: Any) -> Any:
            convention = context.call_conv
            of_kernel = convention.get_function_type(types.none, arguments).as_pointer()
            kernel = builder.inttoptr(parts[0], of_kernel)
            unpacked = cgutils.unpack_tuple(builder, parts[1])
            status, _ = convention.call_function(builder, kernel, types.none, arguments, unpacked)
            with cgutils.if_unlikely(builder, status.is_error):
                convention.return_status_propagate(builder, status)
            return context.get_dummy_value()

        return types.none(types.intp, given), generate

    return call
