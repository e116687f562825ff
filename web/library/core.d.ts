// SPDX-License-Identifier: Apache-2.0
// The loader that emscripten writes.
export default function loadCore(options: {
  instantiateWasm(
    imports: WebAssembly.Imports,
    done: (instance: WebAssembly.Instance) => void,
  ): object;
}): Promise<object>;
