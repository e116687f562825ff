// SPDX-License-Identifier: Apache-2.0
// Keeps the document in the browser, so that it is there again after the page was closed.

import { kEmptyDocument, type Document } from "./document.ts";
import type { ModelFile } from "./protocol.ts";

const kStore = "documents";
/** Changes with the stores of the database. */
const kVersion = 1;

function database(): Promise<IDBDatabase> {
  const request = indexedDB.open("espalier", kVersion);
  request.onupgradeneeded = () => {
    if (!request.result.objectStoreNames.contains(kStore)) request.result.createObjectStore(kStore);
  };
  return promiseOf(request);
}

function promiseOf<T>(request: IDBRequest<T>): Promise<T> {
  return new Promise((resolve, reject) => {
    request.onsuccess = () => resolve(request.result);
    request.onerror = () => reject(request.error);
  });
}

async function withStore<T>(
  mode: IDBTransactionMode,
  use: (store: IDBObjectStore) => IDBRequest<T>,
) {
  const opened = await database();
  try {
    const transaction = opened.transaction(kStore, mode);
    const ended = new Promise<void>((resolve, reject) => {
      transaction.oncomplete = () => resolve();
      transaction.onabort = () => reject(transaction.error);
    });
    const [result] = await Promise.all([promiseOf(use(transaction.objectStore(kStore))), ended]);
    return result;
  } finally {
    opened.close();
  }
}

/** A document as this page or an older one, which had one model, saved it. */
type SavedDocument = Document & { model?: ModelFile | null };

/** The document that was saved last, if there is one and the browser gives it. */
export async function savedDocument(key: string): Promise<Document | null> {
  try {
    const saved = await withStore<SavedDocument>("readonly", (store) => store.get(key));
    if (!saved) return null;
    // An older page may have saved it, without the fields that are new.
    const { model, ...document } = saved;
    return { ...kEmptyDocument, ...document, models: saved.models ?? (model ? [model] : []) };
  } catch {
    return null; // The browser keeps nothing, in a private window say.
  }
}

let timer: ReturnType<typeof setTimeout> | undefined;

/** Saves the document soon; later calls replace earlier ones.
 * @param onFull called if the document is too large for the browser
 */
export function saveSoon(document: Document, key: string, onFull: () => void): void {
  clearTimeout(timer);
  timer = setTimeout(() => void save(document, key, onFull), 400);
}

async function save(document: Document, key: string, onFull: () => void): Promise<void> {
  try {
    await withStore("readwrite", (store) => store.put(document, key));
  } catch (error) {
    // Otherwise the browser keeps nothing, in a private window say: there is no place to save to.
    if (error instanceof DOMException && error.name === "QuotaExceededError") onFull();
  }
}
