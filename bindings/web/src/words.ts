/** Numbers in a row, as uniform blocks have them. */
export class Words {
    private readonly bytes: ArrayBuffer;
    private readonly view: DataView;
    private at = 0;

    constructor(bytes: number) {
        this.bytes = new ArrayBuffer(bytes);
        this.view = new DataView(this.bytes);
    }

    uint(...numbers: number[]): this {
        for (const number of numbers) {
            this.view.setUint32(this.at, number, true);
            this.at += 4;
        }
        return this;
    }

    float(...numbers: number[]): this {
        for (const number of numbers) {
            this.view.setFloat32(this.at, number, true);
            this.at += 4;
        }
        return this;
    }

    /** Goes on at this byte. */
    from(at: number): this {
        this.at = at;
        return this;
    }

    done(): Uint8Array<ArrayBuffer> {
        return new Uint8Array(this.bytes);
    }
}
