import { refuse, refuseProblem } from './refuse.js';

const KEY = 'brdfc.checksum';

const TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
    let code = byte;
    for (let bit = 0; bit < 8; bit += 1) {
        code = (code >>> 1) ^ (code & 1 ? 0xedb88320 : 0);
    }
    return code;
});

/** Verifies the checksum of a file: the CRC-32 of zip over the whole file, with the four bytes of the checksum set to zero. */
export function checkSum(bytes: Uint8Array, entries: Map<string, Uint8Array>): void {
    const value = entries.get(KEY);
    if (value === undefined) {
        return refuseProblem(KEY, 'missing', 'a value of 4 bytes');
    }
    if (value.length !== 4) {
        return refuse(KEY, `${value.length} bytes`, '4 bytes');
    }
    const at = value.byteOffset - bytes.byteOffset;
    let code = 0xffffffff;
    for (let k = 0; k < bytes.length; k += 1) {
        const byte = k >= at && k < at + 4 ? 0 : bytes[k];
        code = TABLE[(code ^ byte) & 0xff] ^ (code >>> 8);
    }
    const [found, stored] = [~code >>> 0, new DataView(value.buffer, value.byteOffset, 4).getUint32(0, true)];
    if (found !== stored) {
        refuse('checksum of the file', found.toString(16), `${stored.toString(16)}, as ${KEY} says; the file is damaged`);
    }
}
