// Compiles WGSL with Tint, the compiler of Chrome, by Dawn's null backend: no graphics card, no driver, no browser.
//
// Input on stdin: JSON, a list of { name, source }. Output: JSON, { features, modules }: the optional features of the device (none),
// and for each module a list of messages { type, line, column, text }.
// Exit code 3: the package 'webgpu' is not installed here, or does not run on this system.

import { text } from 'node:stream/consumers';

let create;
try {
    ({ create } = await import('webgpu'));
} catch (error) {
    console.error(error.message);
    process.exit(3);
}

const gpu = create(['backend=null']);
const device = await (await gpu.requestAdapter()).requestDevice();
// Errors come back as messages; without a listener Dawn would print them, too.
device.addEventListener('uncapturederror', (event) => event.preventDefault());

const modules = [];
for (const { source } of JSON.parse(await text(process.stdin))) {
    const { messages } = await device.createShaderModule({ code: source }).getCompilationInfo();
    modules.push(messages.map(({ type, lineNum, linePos, message }) =>
        ({ type, line: lineNum, column: linePos, text: message })));
}
process.stdout.write(JSON.stringify({ features: [...device.features], modules }), () => process.exit(0));
